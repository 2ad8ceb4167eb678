//! Materials of Wavefront OBJ: colors and textures of its faces.
//!
//! Role: `vt`, `usemtl` and `mtllib` of an OBJ file, `Kd` and `map_Kd` of MTL files. Invariant: a file is read only for a face
//! that uses it. Source: Alias|Wavefront, "MTL material format (Lightwave, OBJ)", 1995. A texture replaces `Kd`, which many
//! programs leave at 0.8 or black beside it.

use super::textures::{Textures, check_spots, decode_texture};
use crate::error::{Location, ShapeError, quoted};
use crate::shape::Mesh;
use crate::shape::looks::linear;
use crate::shape::paint::{Material, Spot};
use crate::shape::texture::Wrap;
use crate::source::{Source, is_absolute, number, tokens};
use foldhash::HashMap;
use glam::DVec3;
use std::path::Path;

/// No texture coordinates.
const NONE: u32 = u32::MAX;

/// Corners of faces with their materials.
#[derive(Default)]
pub(super) struct Faces {
    coordinates: Vec<[f64; 2]>,
    library: HashMap<Vec<u8>, Mtl>,
    /// Materials in the order of their first use, and the first line of a face of each without texture coordinates.
    materials: Vec<(Vec<u8>, Option<u64>)>,
    numbers: HashMap<Vec<u8>, u32>,
    /// Number of the material of the next faces.
    material: u32,
    /// Vertex of each position with its texture coordinates and material.
    vertices: HashMap<[u32; 3], u32>,
    /// Positions of the vertices.
    pub positions: Vec<DVec3>,
    corners: Vec<[u32; 3]>,
}

/// A material of an MTL file.
#[derive(Default)]
struct Mtl {
    color: Option<[f32; 3]>,
    map: Option<Map>,
}

/// A texture of a material.
struct Map {
    /// Its file, beside the OBJ file or below.
    file: String,
    scale: [f64; 2],
    offset: [f64; 2],
    wrap: Wrap,
}

impl Faces {
    /// Takes up a statement other than a face.
    pub fn statement(&mut self, source: &Source, word: &[u8], rest: &[u8]) -> Result<(), ShapeError> {
        match word {
            b"vt" => {
                let [u, v] = match tokens(rest).map(number).collect::<Vec<Option<f64>>>()[..] {
                    [Some(u)] => [u, 0.0],
                    [Some(u), Some(v), ..] => [u, v],
                    _ => return Err(source.malformed("texture coordinates (1 to 3 numbers after `vt`)", rest)),
                };
                self.coordinates.push([u, v]);
                // As many as there may be corners.
                source.check_triangles((self.coordinates.len() as u64).div_ceil(3))
            }
            b"usemtl" => {
                self.material = self.numbered(rest);
                Ok(())
            }
            _ => {
                let is_name = |word: &&[u8]| word.to_ascii_lowercase().ends_with(b".mtl");
                // One name with spaces, or several without.
                let names: Vec<&[u8]> = match tokens(rest).filter(is_name).count() {
                    0 | 1 => vec![rest],
                    _ => tokens(rest).collect(),
                };
                names.into_iter().try_for_each(|name| {
                    let name = source.found(&file_name(name));
                    let folder = Path::new(&name).parent().unwrap_or(Path::new("")).to_path_buf();
                    let read = source.beside(&name, |part| self.read(part, &folder));
                    read.map_err(|error| error.placed(Location::Line(source.line)))
                })
            }
        }
    }

    fn numbered(&mut self, name: &[u8]) -> u32 {
        let next = self.materials.len() as u32;
        *self.numbers.entry(name.to_vec()).or_insert_with(|| {
            self.materials.push((name.to_vec(), None));
            next
        })
    }

    /// The vertex of a corner as `7`, `7/2`, `7//3` or `7/2/3`, whose position has an index and a place.
    pub fn corner(
        &mut self,
        source: &Source,
        line: u64,
        word: &[u8],
        (index, place): (u32, DVec3),
    ) -> Result<u32, ShapeError> {
        if self.materials.is_empty() {
            self.material = self.numbered(b"");
        }
        let digits = word.split(|&byte| byte == b'/').nth(1).unwrap_or_default();
        let count = self.coordinates.len() as i64;
        let from_zero = number(digits).and_then(|at: i64| at.checked_add(if at < 0 { count } else { -1 }));
        let coordinate = match from_zero {
            _ if digits.is_empty() => {
                self.materials[self.material as usize].1.get_or_insert(line);
                NONE
            }
            Some(at) if (0..count).contains(&at) => at as u32,
            _ => return Err(source.malformed("the index of texture coordinates above this line (2 in 7/2)", word)),
        };
        let corner = [index, coordinate, self.material];
        Ok(*self.vertices.entry(corner).or_insert_with(|| {
            self.positions.push(place);
            self.corners.push(corner);
            self.corners.len() as u32 - 1
        }))
    }

    /// Reads an MTL file, which lies in `folder` below that of the OBJ file.
    fn read(&mut self, source: &mut Source, folder: &Path) -> Result<(), ShapeError> {
        source.skip_mark()?;
        let (mut line, mut own) = (Vec::new(), &mut Mtl::default());
        while source.next_line(&mut line)? {
            let (word, rest) = first_word(&line);
            match &*word.to_ascii_lowercase() {
                b"newmtl" => own = self.library.entry(rest.to_vec()).or_default(),
                b"kd" => {
                    let rgb = match tokens(rest).map(number).collect::<Vec<_>>()[..] {
                        [Some(gray)] => [gray; 3],
                        [Some(r), Some(g), Some(b), ..] => [r, g, b],
                        _ => return Err(source.malformed("a color (3 numbers after `Kd`)", rest)),
                    };
                    own.color = Some(rgb.map(linear));
                }
                b"map_kd" => own.map = Some(Map::read(source, rest, folder)?),
                _ => {}
            }
        }
        Ok(())
    }

    /// The mesh of the triangles of its vertices. Textures come before colors of vertices, and those before colors of materials.
    pub fn finish(
        mut self,
        source: &Source,
        positions: &[DVec3],
        colors: &[[f32; 3]],
        mut triangles: Vec<[u32; 3]>,
    ) -> Result<(Mesh, usize), ShapeError> {
        let library = std::mem::take(&mut self.library);
        let mut is_used = vec![false; self.materials.len()];
        self.corners.iter().for_each(|[.., material]| is_used[*material as usize] = true);
        let mut materials = vec![Material::default(); self.materials.len()];
        let (mut maps, mut textures) = (vec![None; self.materials.len()], Textures::default());
        // Material of the faces without texture coordinates of each material.
        let mut bare_materials: Vec<u32> = (0..self.materials.len() as u32).collect();
        for (index, (name, bare)) in self.materials.iter().enumerate().filter(|(index, _)| is_used[*index]) {
            let Some(mtl) = library.get(name) else {
                if !name.is_empty() {
                    source.note(format!("faces of material {} stay unpainted, no file of mtllib has it", quoted(name)));
                }
                continue;
            };
            materials[index].color = mtl.color;
            let Some(map) = &mtl.map else { continue };
            let place = Location::Material(quoted(name));
            let texture = textures.named(source, map.file.clone(), || {
                source.beside(&source.found(&map.file), |part| {
                    let bytes = part.block(part.len, "a picture")?;
                    decode_texture(part, place.clone(), &bytes)
                })
            });
            let texture = Some(texture.map_err(|error| error.placed(place))?);
            let painted = Material { color: Some([1.0; 3]), texture, wraps: [map.wrap; 2] };
            let plain = std::mem::replace(&mut materials[index], painted);
            maps[index] = Some(map);
            if let Some(line) = bare {
                let (name, bare) = (quoted(name), plain.color.map_or("stay unpainted", |_| "have its color `Kd`"));
                source.note(format!(
                    "faces of material {name} without texture coordinates {bare}; the first is in line {line}"
                ));
                bare_materials[index] = materials.len() as u32;
                materials.push(plain);
            }
        }
        let has_texture = maps.iter().any(Option::is_some);
        let has_colors = !has_texture && !colors.is_empty();
        let has_spots = has_texture || !has_colors && materials.iter().any(|material| material.color.is_some());
        if !has_spots {
            triangles.as_flattened_mut().iter_mut().for_each(|corner| *corner = self.corners[*corner as usize][0]);
            return Ok(Mesh::cleaned_with(positions, colors, &[], triangles));
        }
        self.unmix(&mut triangles);
        let spots = self.corners.iter().map(|[_, coordinates, material]| {
            let uv = self.coordinates.get(*coordinates as usize).copied().unwrap_or_default();
            let uv = maps[*material as usize].map_or(uv, |map| map.moved(uv)).map(|part| part as f32);
            Spot { material: if *coordinates == NONE { bare_materials[*material as usize] } else { *material }, uv }
        });
        let spots: Vec<_> = spots.collect();
        check_spots(source, &spots)?;
        let (mut mesh, dropped) = Mesh::cleaned_with(&self.positions, &[], &spots, triangles);
        mesh.paint.materials = materials;
        Ok((mesh, dropped))
    }
}

impl Faces {
    /// Takes the texture coordinates from the triangles of which a corner has none: they have one material.
    fn unmix(&mut self, triangles: &mut [[u32; 3]]) {
        for triangle in triangles {
            if !triangle.iter().any(|corner| self.corners[*corner as usize][1] == NONE) {
                continue;
            }
            for corner in triangle {
                let [index, _, material] = self.corners[*corner as usize];
                let (bare, next) = ([index, NONE, material], self.corners.len() as u32);
                let place = self.positions[*corner as usize];
                *corner = *self.vertices.entry(bare).or_insert(next);
                if *corner == next {
                    self.corners.push(bare);
                    self.positions.push(place);
                }
            }
        }
    }
}

impl Map {
    /// Reads the options of a texture and its name. Options that change no place are passed over.
    fn read(source: &Source, mut rest: &[u8], folder: &Path) -> Result<Map, ShapeError> {
        let mut map = Map { file: String::new(), scale: [1.0; 2], offset: [0.0; 2], wrap: Wrap::Repeat };
        while rest.starts_with(b"-") {
            let (option, after) = first_word(rest);
            rest = after;
            let mut values = Vec::new();
            let most = match option {
                b"-s" | b"-o" | b"-t" => 3,
                b"-mm" => 2,
                b"-blendu" | b"-blendv" | b"-cc" | b"-clamp" | b"-bm" | b"-boost" | b"-texres" | b"-imfchan" => 1,
                _ => return Err(source.malformed("an option of MTL, or the name of a texture", option)),
            };
            while values.len() < most {
                let (value, after) = first_word(rest);
                if most == 3 && number::<f64>(value).is_none() {
                    break;
                }
                values.push(value);
                rest = after;
            }
            let numbers = |own: [f64; 2]| {
                [0, 1].map(|axis| values.get(axis).and_then(|value| number(value)).unwrap_or(own[axis]))
            };
            match option {
                b"-s" => map.scale = numbers(map.scale),
                b"-o" => map.offset = numbers(map.offset),
                b"-clamp" if values == [b"on"] => map.wrap = Wrap::Clamp,
                _ => {}
            }
        }
        if rest.is_empty() {
            return Err(source.malformed("the name of a texture after `map_Kd`", rest));
        }
        // Some programs write the options behind the name.
        let late =
            rest.windows(4).position(|part| matches!(part, b" -s " | b" -o " | b" -t " | b" -mm" | b" -bm" | b" -cl"));
        if let Some(at) = late {
            let behind = [&rest[at..], b" name"].concat();
            let options = Map::read(source, behind.trim_ascii(), Path::new(""))?;
            (map.scale, map.offset, map.wrap) = (options.scale, options.offset, options.wrap);
            rest = rest[..at].trim_ascii_end();
        }
        let name = file_name(rest);
        map.file = if is_absolute(&name) { name } else { folder.join(name).to_string_lossy().into_owned() };
        Ok(map)
    }

    /// Texture coordinates with v from the first row on; those of OBJ begin at the last.
    fn moved(&self, uv: [f64; 2]) -> [f64; 2] {
        let [u, v] = [0, 1].map(|axis| uv[axis] * self.scale[axis] + self.offset[axis]);
        [u, 1.0 - v]
    }
}

/// The first word of a text, and the rest.
pub(super) fn first_word(text: &[u8]) -> (&[u8], &[u8]) {
    let text = text.trim_ascii();
    let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    (&text[..end], text[end..].trim_ascii())
}

/// A name with the separators of folders that this system has.
fn file_name(bytes: &[u8]) -> String {
    let bytes = bytes.strip_prefix(b"\"").and_then(|bytes| bytes.strip_suffix(b"\"")).unwrap_or(bytes);
    String::from_utf8_lossy(bytes).replace('\\', "/")
}
