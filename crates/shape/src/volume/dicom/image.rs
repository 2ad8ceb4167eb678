//! Image of a DICOM file: description and pixels.
//!
//! Invariant: elements that change the values or places of pixels are understood, or refused when the image is used. Source:
//! NEMA PS3.3, C.7.6.2, C.7.6.3, C.7.6.16 and C.11.1, and PS3.5, 8.

use super::elements::{Element, Elements, PER_FRAME, PIXELS, SHARED, UNDEFINED};
use super::frames::{Fragments, PixelEncoding};
use super::header::{DicomHeader, Refusal};
use crate::error::{Found, Location, ShapeError, quoted};
use crate::source::Source;
use glam::DVec3;

/// Most frames of a file or folder. A frame in memory is many times as long as its shortest item in a file.
pub(super) const MAX_FRAMES: usize = 1 << 16;

/// Longest list of numbers: 16 characters for each of the most frames, and a separator.
const MAX_NUMBERS: u32 = 17 << 16;

/// Attributes of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Frame {
    /// Center of the first pixel, in mm.
    pub position: Option<[f64; 3]>,
    /// Directions along rows and along columns.
    pub orientation: Option<[f64; 6]>,
    /// Distances between rows and between columns, in mm.
    pub spacing: Option<[f64; 2]>,
    pub slope: Option<f64>,
    pub intercept: Option<f64>,
}

/// Attributes of an image.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Image {
    /// Series instance UID.
    pub series: String,
    pub rows: u16,
    pub columns: u16,
    pub frames: Vec<Frame>,
    /// Declared number of frames.
    count: u64,
    pub encoding: PixelEncoding,
    samples: u16,
    photometric: String,
    /// Bits allocated, bits stored, high bit.
    bits: [u16; 3],
    is_signed: bool,
    /// Unsupported part.
    refused: Option<Refusal>,
    data: Option<Pixels>,
    spacings: Spacings,
}

/// Distances of frames without places of their own, in mm.
#[derive(Clone, Debug, Default, PartialEq)]
struct Spacings {
    /// SpacingBetweenSlices and SliceThickness.
    between: Option<f64>,
    thickness: Option<f64>,
    /// ImagerPixelSpacing.
    imager: Option<[f64; 2]>,
    /// GridFrameOffsetVector.
    offsets: Vec<f64>,
}

/// Location of the pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pixels {
    big_endian: bool,
    /// Declared length, offset, and bytes to the end of the file.
    bytes: u32,
    offset: u64,
    left: u64,
}

impl Frame {
    /// Attributes of the frame, or else of `common`.
    fn or(self, common: Frame) -> Frame {
        Frame {
            position: self.position.or(common.position),
            orientation: self.orientation.or(common.orientation),
            spacing: self.spacing.or(common.spacing),
            slope: self.slope.or(common.slope),
            intercept: self.intercept.or(common.intercept),
        }
    }

    /// Takes an attribute of frames; returns whether `head` is one.
    fn takes(&mut self, elements: &mut Elements, head: &Element) -> Result<bool, ShapeError> {
        match head.tag {
            0x0020_0032 => self.position = Some(numbers(elements, head, "ImagePositionPatient of 3 numbers")?),
            0x0020_0037 => self.orientation = Some(numbers(elements, head, "ImageOrientationPatient of 6 numbers")?),
            0x0028_0030 => self.spacing = Some(numbers(elements, head, "PixelSpacing of 2 numbers")?),
            0x0028_1052 => self.intercept = known(elements, head, "RescaleIntercept of one number")?,
            0x0028_1053 => self.slope = known(elements, head, "RescaleSlope of one number")?,
            _ => return Ok(false),
        }
        Ok(true)
    }
}

/// Decimal numbers of an element.
fn numbers<const N: usize>(
    elements: &mut Elements,
    head: &Element,
    expected: &'static str,
) -> Result<[f64; N], ShapeError> {
    let place = Location::Byte(elements.source.offset);
    let text = elements.text(head)?;
    let finite = |part: &str| part.trim().parse().ok().filter(|number: &f64| number.is_finite());
    let parts: Option<Vec<f64>> = text.split('\\').map(finite).collect();
    let parts = parts.and_then(|parts| parts.try_into().ok());
    parts.ok_or_else(|| elements.source.malformed_at(place, expected, quoted(text.as_bytes())))
}

/// Number of an element; `None` if it is empty or NaN.
fn known(elements: &mut Elements, head: &Element, expected: &'static str) -> Result<Option<f64>, ShapeError> {
    let place = Location::Byte(elements.source.offset);
    let text = elements.text(head)?;
    match text.parse() {
        Ok(number) if f64::is_finite(number) => Ok(Some(number)),
        Ok(number) if f64::is_nan(number) => {
            let name = expected.split(' ').next().unwrap_or_default();
            elements.source.note(format!("{name} is NaN: it is ignored"));
            Ok(None)
        }
        _ if text.is_empty() => Ok(None),
        _ => Err(elements.source.malformed_at(place, expected, quoted(text.as_bytes()))),
    }
}

/// Finite numbers of an element that matter only to frames without places; empty if the element is long, or holds another
/// value.
fn numbers_of(elements: &mut Elements, head: &Element) -> Result<Vec<f64>, ShapeError> {
    if head.length > MAX_NUMBERS {
        elements.skip(head)?;
        return Ok(Vec::new());
    }
    let bytes = elements.source.block(u64::from(head.length), "numbers of DICOM")?;
    let text = String::from_utf8_lossy(&bytes);
    let finite = |part: &str| {
        let part = part.trim_matches(|c: char| c == '\0' || c.is_whitespace());
        part.parse().ok().filter(|number: &f64| number.is_finite())
    };
    Ok(text.split('\\').map(finite).collect::<Option<_>>().unwrap_or_default())
}

fn number(elements: &mut Elements, head: &Element, expected: &'static str) -> Result<f64, ShapeError> {
    numbers::<1>(elements, head, expected).map(|[number]| number)
}

impl Image {
    /// Reads up to the pixels, or to the end of the file.
    pub fn read(source: &mut Source) -> Result<Image, ShapeError> {
        let DicomHeader { syntax, encoding, refused, .. } = DicomHeader::read(source)?;
        let mut image = Image { count: 1, samples: 1, encoding, refused, ..Image::default() };
        let (mut common, mut shared) = (Frame::default(), Frame::default());
        let mut elements = Elements::new(source, syntax);
        while let Some(head) = elements.next()? {
            if head.tag == PIXELS {
                if syntax.big_endian && &head.kind == b"OW" && image.bits[0] != 16 {
                    let (found, remedy) =
                        (image.bits[0].to_string(), "rewrite it by `dcmconv +te`, the lowest byte first");
                    image.refused = Some(("in words with the highest byte first, BitsAllocated", found, remedy));
                }
                let (offset, left) = (elements.source.offset, elements.source.remaining());
                image.data = Some(Pixels { big_endian: syntax.big_endian, bytes: head.length, offset, left });
                break;
            }
            let is_taken = match elements.group() {
                None => common.takes(&mut elements, &head)? || image.takes(&mut elements, &head)?,
                Some((PER_FRAME, index)) => {
                    if index >= MAX_FRAMES {
                        let place = Location::Byte(elements.source.offset);
                        let expected = "at most 65536 frames in a file";
                        return Err(elements.source.malformed_at(place, expected, "more".into()));
                    }
                    image.frames.resize(image.frames.len().max(index + 1), Frame::default());
                    image.frames[index].takes(&mut elements, &head)?
                }
                Some((SHARED, _)) => shared.takes(&mut elements, &head)?,
                Some(_) => false,
            };
            if !is_taken {
                elements.skip(&head)?;
            }
        }
        if elements.has_table {
            let remedy = "write its values into the pixels";
            image.refused = Some(("an image with", "a ModalityLUTSequence".into(), remedy));
        }
        if image.frames.is_empty() && image.count == 1 {
            image.frames.push(Frame::default());
        }
        if image.frames.is_empty() && (2..=MAX_FRAMES as u64).contains(&image.count) {
            image.stack_frames(source, shared.or(common));
        }
        image.frames.iter_mut().for_each(|frame| *frame = frame.or(shared).or(common));
        Ok(image)
    }

    /// Puts frames without places of their own one above the other.
    fn stack_frames(&mut self, source: &Source, first: Frame) {
        let Spacings { between, thickness, imager, offsets } = &self.spacings;
        let orientation = first.orientation.unwrap_or([1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let spacing = first.spacing.or(*imager).unwrap_or([1.0; 2]);
        let [a, b, c, d, e, f] = orientation;
        let normal = DVec3::new(a, b, c).cross(DVec3::new(d, e, f));
        let position = DVec3::from(first.position.unwrap_or_default());
        let above = |step: &Option<f64>| step.map(f64::abs).filter(|step| *step > 0.0);
        let (step, from) = match (above(between), above(thickness)) {
            (Some(step), _) => (step, "SpacingBetweenSlices"),
            (None, Some(step)) => (step, "SliceThickness"),
            (None, None) => (1.0, "nothing"),
        };
        let are_offset = offsets.len() as u64 == self.count;
        let height = |index: u64| match offsets.get(index as usize) {
            Some(offset) if are_offset => offset - offsets[0],
            _ => step * index as f64,
        };
        let at = |index| Some((position + normal * height(index)).to_array());
        let frame =
            |index| Frame { position: at(index), orientation: Some(orientation), spacing: Some(spacing), ..first };
        self.frames = (0..self.count).map(frame).collect();
        let how = if are_offset {
            "they lie as GridFrameOffsetVector says".into()
        } else {
            format!("they are put {step} mm apart, as {from} says")
        };
        let sides = if first.spacing.or(*imager).is_none() { "; its pixels are taken to be 1 mm wide" } else { "" };
        source.note(format!("its {} frames have no places of their own: {how}{sides}", self.count));
    }

    /// Takes an attribute of the image; returns whether `head` is one.
    fn takes(&mut self, elements: &mut Elements, head: &Element) -> Result<bool, ShapeError> {
        match head.tag {
            0x0020_000e => self.series = elements.text(head)?,
            0x0028_0002 => self.samples = elements.short(head)?,
            0x0028_0004 => self.photometric = elements.text(head)?,
            0x0028_0008 => self.count = number(elements, head, "NumberOfFrames of one number")? as u64,
            0x0028_0010 => self.rows = elements.short(head)?,
            0x0028_0011 => self.columns = elements.short(head)?,
            0x0028_0100 => self.bits[0] = elements.short(head)?,
            0x0028_0101 => self.bits[1] = elements.short(head)?,
            0x0028_0102 => self.bits[2] = elements.short(head)?,
            0x0028_0103 => self.is_signed = elements.short(head)? != 0,
            0x0018_0050 => self.spacings.thickness = numbers_of(elements, head)?.first().copied(),
            0x0018_0088 => self.spacings.between = numbers_of(elements, head)?.first().copied(),
            0x0018_1164 => self.spacings.imager = numbers_of(elements, head)?.first_chunk().copied(),
            0x3004_000c => self.spacings.offsets = numbers_of(elements, head)?,
            0x7fe0_0008 | 0x7fe0_0009 => {
                let remedy = "convert them to integers with RescaleSlope and RescaleIntercept";
                self.refused = Some(("an image of", "floats".into(), remedy));
                elements.skip(head)?;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Whether the file has an image.
    pub fn is_picture(&self) -> bool {
        self.rows > 0 && self.columns > 0 && (self.data.is_some() || self.refused.is_some())
    }

    /// Whether the image is a single slice.
    pub(crate) fn is_slice(&self) -> bool {
        self.is_picture() && self.frames.len() < 2 && self.count < 2
    }

    pub fn pixels(&self) -> usize {
        usize::from(self.rows) * usize::from(self.columns)
    }

    fn frame_bytes(&self) -> u64 {
        self.pixels() as u64 * u64::from(self.bits[0] / 8)
    }

    /// Checks that the pixels are supported.
    pub fn check(&self, source: &Source, file: &str) -> Result<(), ShapeError> {
        let unsupported =
            |what, found, remedy| Err(ShapeError::unsupported(file, Location::Header, what, found, remedy));
        let wrong = |expected, found| {
            Err(ShapeError::Malformed { file: file.into(), place: Location::Header, expected, found })
        };
        if let Some((what, found, remedy)) = &self.refused {
            return unsupported(what, found.clone(), remedy);
        }
        let Some(pixels) = self.data.filter(|_| self.is_picture()) else {
            return wrong("Rows, Columns and pixels (7FE0,0010)", "no picture".into());
        };
        if self.samples != 1 {
            return unsupported("SamplesPerPixel", self.samples.to_string(), "convert it to grey values: 1 is read");
        }
        if self.photometric != "MONOCHROME2" {
            let found = quoted(self.photometric.as_bytes());
            return unsupported("PhotometricInterpretation", found, "convert it to MONOCHROME2");
        }
        let [allocated, stored, high] = self.bits;
        if !matches!(allocated, 8 | 16 | 32) {
            return unsupported("BitsAllocated", allocated.to_string(), "8, 16 and 32 are read");
        }
        if stored == 0 || high >= allocated || high + 1 < stored {
            let found = format!("{stored} bits up to bit {high} of {allocated}");
            return wrong("BitsStored and HighBit inside of BitsAllocated", found);
        }
        if self.count == 0 || self.count != self.frames.len() as u64 {
            let found = format!("{} frames, {} of them with a place", self.count, self.frames.len());
            return unsupported("a file of", found, "each needs one (5200,9230): save each frame as a file");
        }
        if self.frames.iter().any(|frame| frame.slope == Some(0.0)) {
            return wrong("RescaleSlope that is not 0", "0".into());
        }
        let declared = self.frame_bytes() * self.count;
        let short = |found| {
            let (file, what) = (file.into(), "pixels".into());
            Err(ShapeError::DataSize { file, offset: pixels.offset, declared, what, found })
        };
        if self.encoding != PixelEncoding::Plain {
            if pixels.bytes != UNDEFINED {
                let found = format!("{} bytes", pixels.bytes);
                return wrong("packed pixels (7FE0,0010) in fragments, without a length of all", found);
            }
            let most = pixels.left.saturating_mul(self.encoding.max_ratio());
            return if declared > most { short(Found::AtMost(most)) } else { Ok(()) };
        }
        if u64::from(pixels.bytes) < declared || pixels.bytes == UNDEFINED {
            let found = format!(
                "{} for {} x {} x {} pixels of {allocated} bits",
                pixels.bytes, self.columns, self.rows, self.count
            );
            return wrong("as many bytes of pixels as Rows, Columns and BitsAllocated say", found);
        }
        let more = u64::from(pixels.bytes).min(pixels.left).saturating_sub(declared + declared % 2);
        if more > 0 {
            source.note(format!("bytes after its last pixel are left out: {more}"));
        }
        if declared > pixels.left { short(Found::Bytes(pixels.left)) } else { Ok(()) }
    }

    /// Reader of compressed frames; the pixel data is next in the source.
    pub fn fragments(&self, source: &mut Source) -> Result<Option<Fragments>, ShapeError> {
        (self.encoding != PixelEncoding::Plain).then(|| Fragments::read(source, self.frames.len())).transpose()
    }

    /// Reads the values of the next frame, that of `index`.
    pub fn values(
        &self,
        source: &mut Source,
        fragments: Option<&mut Fragments>,
        index: usize,
        values: &mut [f32],
    ) -> Result<(), ShapeError> {
        let [allocated, stored, high] = self.bits.map(u32::from);
        let (Some(pixels), Some(frame)) = (self.data, self.frames.get(index)) else { return Ok(()) };
        let sides = [self.columns, self.rows];
        let block = match fragments {
            Some(fragments) => fragments.frame(source, index, self.encoding, sides, allocated as usize / 8)?,
            None => source.block(self.frame_bytes(), "pixels of a frame")?,
        };
        let (slope, intercept) = (frame.slope.unwrap_or(1.0), frame.intercept.unwrap_or(0.0));
        // The left shift drops bits above the value, the right shift those below it, with sign extension.
        let (left, right) = (31 - high, 32 - stored);
        let width = allocated as usize / 8;
        for (value, pixel) in values.iter_mut().zip(block.chunks_exact(width)) {
            let mut raw = [0; 4];
            raw[..width].copy_from_slice(pixel);
            if pixels.big_endian {
                raw[..width].reverse();
            }
            let raw = u32::from_le_bytes(raw) << left;
            let stored = if self.is_signed { f64::from(raw as i32 >> right) } else { f64::from(raw >> right) };
            *value = (slope * stored + intercept) as f32;
        }
        Ok(())
    }
}
