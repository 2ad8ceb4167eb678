//! Shards: one picture, or one sequence, split among independent processes.
//!
//! Role: the rows of each shard, its file, and the merge of the files. Invariant: every split gives the pixels of the whole
//! picture bit for bit; the checksum of each file is verified, and a merge needs all shards. Source: PH 3.1 (interleaved
//! pixels on 64 processors, a dozen workstations).

use crate::output::{Depth, Provenance};
use crate::render::{Frame, Measurements};
use crate::scene::Color;
use blake3::Hash;
use hypertexture_support::open::{self, OpenError};
use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Most shards of one picture.
const MAX_COUNT: u32 = 65_536;
/// Wanted bands per shard. Lower: one shard gets the object and another the background.
const BANDS: u32 = 8;
/// Divisor of the rows of a band. Lower: devices that shade blocks of 4 x 4 pixels waste most of them.
const BAND_STEP: u32 = 4;
/// Most rows of a band. Higher: a small object falls into few bands.
const BAND_ROWS: u32 = 32;
/// Longest side of a picture, as in scenes.
const MAX_SIDE: u32 = 16_384;
/// Size limit of a file: the largest picture with its provenance.
const MAX_BYTES: u64 = 16 * (MAX_SIDE as u64).pow(2) + (16 << 20);
const MAGIC: &[u8; 8] = b"HTSHARD2";
/// Bytes of a BLAKE3 hash.
const HASH: usize = 32;

/// Shard `index` of `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u32,
    count: u32,
}

/// Errors of shards and of their merge.
#[allow(missing_docs, reason = "the names of the fields describe them")]
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShardError {
    /// Malformed specification.
    #[error("shard {0}: write K/N with K from 0 to N - 1 and N from 1 to {MAX_COUNT}, such as 0/4, or auto")]
    Spec(String),
    /// The environment does not specify the shard.
    #[error(
        "--shard auto: {0}; it is set by Slurm (SLURM_ARRAY_TASK_ID, SLURM_ARRAY_TASK_COUNT) or Kubernetes \
         (JOB_COMPLETION_INDEX, with JOB_COMPLETIONS or HYPERTEXTURE_SHARD_COUNT); otherwise give --shard K/N"
    )]
    Environment(String),
    /// A shard cannot be read.
    #[error("{path}: {source}")]
    Read { path: String, source: io::Error },
    /// The file is not a shard, or is damaged.
    #[error("{path}: {what}")]
    Damaged { path: String, what: &'static str },
    /// Two files belong to different pictures.
    #[error("{path} and {first} are not shards of one picture: they differ in {what}; render one of them again")]
    Foreign { path: String, first: String, what: &'static str },
    /// Two files hold the same shard with different pixels.
    #[error("{path} and {first} both hold shard {shard}, with different content; leave one of them out")]
    Twice { path: String, first: String, shard: Shard },
    /// Shards are missing.
    #[error("{missing} of {count} shards missing: {which}; render with --shard {first}")]
    Missing { missing: usize, count: u32, which: String, first: Shard },
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = ShardError;

    /// Reads `K/N`.
    fn from_str(text: &str) -> Result<Shard, ShardError> {
        let parsed = text.split_once('/').and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
        parsed.and_then(|(index, count)| Shard::new(index, count)).ok_or_else(|| ShardError::Spec(text.into()))
    }
}

impl Shard {
    /// Shard `index` of `count`, counted from 0; `None` unless `index < count <= 65536`.
    pub fn new(index: u32, count: u32) -> Option<Shard> {
        (index < count && count <= MAX_COUNT).then_some(Shard { index, count })
    }

    /// The part that a job array of Slurm or an indexed job of Kubernetes gives to this process. `variable` looks up an
    /// environment variable.
    ///
    /// # Errors
    /// A variable that is missing or makes no sense.
    pub fn from_environment(variable: impl Fn(&str) -> Option<String>) -> Result<Shard, ShardError> {
        let number = |name: &str| match variable(name) {
            None => Ok(None),
            Some(text) => match text.trim().parse::<u32>() {
                Ok(number) => Ok(Some(number)),
                Err(_) => Err(ShardError::Environment(format!("{name} = {text} is not a whole number"))),
            },
        };
        let missing = |name: &str| ShardError::Environment(format!("{name} is not set"));
        let (index, count) = if let Some(task) = number("SLURM_ARRAY_TASK_ID")? {
            let first = number("SLURM_ARRAY_TASK_MIN")?.unwrap_or(0);
            let step = number("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1).max(1);
            let count = number("SLURM_ARRAY_TASK_COUNT")?.ok_or_else(|| missing("SLURM_ARRAY_TASK_COUNT"))?;
            (task.saturating_sub(first) / step, count)
        } else if let Some(index) = number("JOB_COMPLETION_INDEX")? {
            let count = match number("JOB_COMPLETIONS")? {
                Some(count) => count,
                None => number("HYPERTEXTURE_SHARD_COUNT")?
                    .ok_or_else(|| missing("JOB_COMPLETIONS or HYPERTEXTURE_SHARD_COUNT"))?,
            };
            (index, count)
        } else {
            return Err(missing("SLURM_ARRAY_TASK_ID or JOB_COMPLETION_INDEX"));
        };
        Shard::new(index, count)
            .ok_or_else(|| ShardError::Environment(format!("it says shard {index} of {count}, counted from 0")))
    }

    /// Whether frame `number` of a sequence belongs to this shard, as every `count`-th does.
    pub fn takes(self, number: u32) -> bool {
        number % self.count == self.index
    }

    /// The rows of this shard: every `count`-th band of some rows. Empty if the picture has fewer bands than shards.
    pub fn bands(self, height: u32) -> Vec<Range<u32>> {
        let rows = if self.count == 1 { height.max(1) } else { band_rows(height, self.count) };
        let starts = (0..height).step_by(rows as usize);
        let own = starts.skip(self.index as usize).step_by(self.count as usize);
        own.map(|start| start..(start + rows).min(height)).collect()
    }

    /// File of this shard of the picture `output`.
    pub fn path(self, output: &Path) -> PathBuf {
        output.with_extension(self.suffix())
    }

    /// Part of file names that denotes this shard.
    pub fn suffix(self) -> String {
        format!("shard-{}-of-{}", self.index, self.count)
    }
}

/// Number of rows of a band.
fn band_rows(height: u32, count: u32) -> u32 {
    (height / (BANDS * count) / BAND_STEP * BAND_STEP).clamp(BAND_STEP, BAND_ROWS)
}

/// Header of a shard: the properties of the whole picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Whole {
    /// [`identity`](super::identity) of the scene.
    pub identity: Hash,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Color behind the object; `None` for transparent.
    pub background: Option<Color>,
    /// Bits of each channel of a PNG.
    pub depth: Depth,
    /// Provenance, which may differ between shards: by device, and by paths.
    pub provenance: Provenance,
}

/// Encodes the file of a shard: magic, header, pixels of its bands from the top (little-endian f32, premultiplied linear
/// RGBA), and the BLAKE3 hash of everything before.
pub fn encode(whole: &Whole, shard: Shard, frame: &Frame) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(whole.identity.as_bytes());
    let background = whole.background.map_or(0, |Color([r, g, b])| u32::from_be_bytes([1, r, g, b]));
    let depth = if whole.depth == Depth::Sixteen { 16 } else { 8 };
    for number in [whole.size[0], whole.size[1], shard.index, shard.count, background, depth] {
        bytes.extend(number.to_le_bytes());
    }
    let text = whole.provenance.to_text();
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(text.as_bytes());
    for band in shard.bands(whole.size[1]) {
        let pixels = &frame.pixels[span(&band, whole.size[0])];
        bytes.extend(pixels.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
    }
    let hash = blake3::hash(&bytes);
    bytes.extend(hash.as_bytes());
    bytes
}

/// Range of the pixels of a band in a picture.
fn span(band: &Range<u32>, width: u32) -> Range<usize> {
    band.start as usize * width as usize..band.end as usize * width as usize
}

/// Merges the shards of a picture into the pixels that one process would have rendered, bit for bit. Also returns the
/// devices other than the first.
///
/// # Errors
/// A file cannot be read or is damaged, shards belong to different pictures, one exists twice with different content, or one
/// is missing.
pub fn merge(paths: &[PathBuf]) -> Result<(Frame, Whole, Vec<String>), ShardError> {
    let mut first: Option<(String, Whole, u32)> = None;
    let mut found: BTreeMap<u32, (String, Hash)> = BTreeMap::new();
    let mut pixels = Vec::new();
    let mut devices = Vec::new();
    for path in paths {
        let name = path.display().to_string();
        let bytes = bytes_of(path).map_err(|error| ShardError::Read { path: name.clone(), source: error.into() })?;
        let (whole, shard, rows) = decode(&bytes).map_err(|what| ShardError::Damaged { path: name.clone(), what })?;
        let (one, of, count) = first.get_or_insert_with(|| (name.clone(), whole.clone(), shard.count));
        if let Some(what) = difference((of, *count), (&whole, shard.count)) {
            return Err(ShardError::Foreign { path: name, first: one.clone(), what });
        }
        let device = whole.provenance.device;
        if device != of.provenance.device && !devices.contains(&device) {
            devices.push(device);
        }
        let content = blake3::hash(rows);
        match found.get(&shard.index) {
            Some((_, same)) if *same == content => continue,
            Some((first, _)) => return Err(ShardError::Twice { path: name, first: first.clone(), shard }),
            None => drop(found.insert(shard.index, (name, content))),
        }
        let [width, height] = whole.size;
        pixels.resize(width as usize * height as usize, [0.0; 4]);
        let mut values = rows.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        for band in shard.bands(height) {
            let own = pixels[span(&band, width)].as_flattened_mut();
            own.iter_mut().zip(&mut values).for_each(|(pixel, value)| *pixel = value);
        }
    }
    let Some((_, mut whole, count)) = first else { return Err(ShardError::Spec("of no files".into())) };
    let missing: Vec<Shard> =
        (0..count).filter(|index| !found.contains_key(index)).map(|index| Shard { index, count }).collect();
    if let Some(&first) = missing.first() {
        let some: Vec<String> = missing.iter().take(8).map(|shard| shard.index.to_string()).collect();
        let which = format!("{}{}", some.join(", "), if missing.len() > some.len() { ", ..." } else { "" });
        return Err(ShardError::Missing { missing: missing.len(), count, which, first });
    }
    for device in &devices {
        whole.provenance.device.push_str(&format!(", {device}"));
    }
    Ok((Frame { size: whole.size, pixels, measurements: Measurements::default() }, whole, devices))
}

/// Content of a file; only the start if it is not a shard.
fn bytes_of(path: &Path) -> Result<Vec<u8>, OpenError> {
    let mut start = Vec::new();
    open::open(path, MAX_BYTES)?.0.take(MAGIC.len() as u64).read_to_end(&mut start)?;
    if start == MAGIC { open::bytes(path, MAX_BYTES) } else { Ok(start) }
}

/// Illegal difference between two shards.
fn difference(a: (&Whole, u32), b: (&Whole, u32)) -> Option<&'static str> {
    let info = [
        (a.0.size == b.0.size, "the size of the picture"),
        (a.1 == b.1, "the number of shards"),
        (a.0.identity == b.0.identity, "the scene, the object or the version of hypertexture"),
        ((a.0.depth, a.0.background) == (b.0.depth, b.0.background), "the depth or the background"),
    ];
    info.into_iter().find(|(same, _)| !same).map(|(_, what)| what)
}

/// Decodes a file: the whole picture, the shard, and the bytes of its pixels.
fn decode(bytes: &[u8]) -> Result<(Whole, Shard, &[u8]), &'static str> {
    if !bytes.starts_with(MAGIC) {
        return Err("not a shard of hypertexture; name the files that `render --shard` wrote");
    }
    let split = bytes.len().checked_sub(HASH).ok_or("the file ends early; render this shard again")?;
    let (content, hash) = bytes.split_at(split);
    if blake3::hash(content).as_bytes() != hash {
        return Err("the file is damaged: its checksum does not hold; render this shard again");
    }
    header(&content[MAGIC.len()..]).ok_or("the file does not hold what its header says; render this shard again")
}

fn header(bytes: &[u8]) -> Option<(Whole, Shard, &[u8])> {
    let (identity, mut rest) = bytes.split_first_chunk::<HASH>()?;
    let mut numbers = [0; 6];
    for number in &mut numbers {
        *number = take_number(&mut rest)?;
    }
    let [width, height, index, count, background, depth] = numbers;
    let length = take_number(&mut rest)? as usize;
    let (text, rest) = rest.split_at_checked(length)?;
    let provenance = Provenance::from_text(str::from_utf8(text).ok()?).ok()?;
    let whole = Whole {
        identity: Hash::from_bytes(*identity),
        size: [width, height],
        background: match background.to_be_bytes() {
            [0, ..] => None,
            [_, r, g, b] => Some(Color([r, g, b])),
        },
        depth: if depth == 16 { Depth::Sixteen } else { Depth::Eight },
        provenance,
    };
    let shard = Shard::new(index, count)?;
    let sides = 1..=MAX_SIDE;
    (sides.contains(&width) && sides.contains(&height)).then_some(())?;
    let own: usize = shard.bands(height).iter().map(|band| span(band, width).len()).sum();
    (rest.len() == own * 16).then_some((whole, shard, rest))
}

fn take_number(bytes: &mut &[u8]) -> Option<u32> {
    let (number, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(u32::from_le_bytes(*number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn p52_every_row_belongs_to_one_shard() {
        for (height, count) in [(1, 1), (61, 3), (512, 64), (97, 8), (16384, 65536)] {
            let mut owners = vec![0; height as usize];
            for index in 0..count {
                let shard = Shard::new(index, count).unwrap();
                shard.bands(height).into_iter().flatten().for_each(|row| owners[row as usize] += 1);
            }
            assert!(owners.iter().all(|&owners| owners == 1), "{height} rows in {count} shards");
        }
    }

    #[test]
    fn p53_the_shard_of_a_job_array_starts_at_its_first_task() {
        let from = |pairs: &[(&str, &str)]| {
            let pairs: BTreeMap<String, String> = pairs.iter().map(|(k, v)| (k.to_string(), v.to_string())).collect();
            Shard::from_environment(|name| pairs.get(name).cloned()).map_err(|error| error.to_string())
        };
        let slurm = |id, count, min, step| {
            from(&[
                ("SLURM_ARRAY_TASK_ID", id),
                ("SLURM_ARRAY_TASK_COUNT", count),
                ("SLURM_ARRAY_TASK_MIN", min),
                ("SLURM_ARRAY_TASK_STEP", step),
            ])
        };
        assert_eq!(slurm("7", "4", "5", "1"), Ok(Shard { index: 2, count: 4 }));
        assert_eq!(slurm("6", "4", "0", "2"), Ok(Shard { index: 3, count: 4 }));
        assert!(slurm("9", "3", "1", "1").unwrap_err().contains("shard 8 of 3"));
        assert!(slurm("x", "3", "1", "1").unwrap_err().contains("SLURM_ARRAY_TASK_ID = x"));
        assert!(from(&[("SLURM_ARRAY_TASK_ID", "1")]).unwrap_err().contains("SLURM_ARRAY_TASK_COUNT is not set"));
        let index = ("JOB_COMPLETION_INDEX", "3");
        assert_eq!(from(&[index, ("JOB_COMPLETIONS", "8")]), Ok(Shard { index: 3, count: 8 }));
        assert_eq!(from(&[index, ("HYPERTEXTURE_SHARD_COUNT", "5")]), Ok(Shard { index: 3, count: 5 }));
        assert!(from(&[index]).unwrap_err().contains("HYPERTEXTURE_SHARD_COUNT is not set"));
        assert!(from(&[]).unwrap_err().contains("--shard K/N"));
    }

    #[test]
    fn a_shard_is_written_k_of_n() {
        assert_eq!("2/3".parse::<Shard>().unwrap(), Shard { index: 2, count: 3 });
        for wrong in ["3/3", "0/0", "1", "-1/2", "a/b", "1/2/3", "0/65537"] {
            assert!(wrong.parse::<Shard>().unwrap_err().to_string().contains("write K/N"), "{wrong}");
        }
        assert_eq!(Shard { index: 1, count: 4 }.path(Path::new("a/out.png")), Path::new("a/out.shard-1-of-4"));
    }
}
