//! Header of a PLY file: its encoding and the properties of its elements.

use crate::error::{Location, ShapeError};
use crate::sample_type::SampleType;
use crate::source::{Source, number, tokens};

/// Type by its PLY name; those of 64 bits are a common extension.
fn number_type(name: &[u8]) -> Option<SampleType> {
    Some(match name {
        b"char" => SampleType::I8,
        b"uchar" => SampleType::U8,
        b"short" => SampleType::I16,
        b"ushort" => SampleType::U16,
        b"int" => SampleType::I32,
        b"uint" => SampleType::U32,
        b"long" => SampleType::I64,
        b"ulong" => SampleType::U64,
        b"float" => SampleType::F32,
        b"double" => SampleType::F64,
        name => return number(name), // `int8` to `float64`
    })
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Little,
    Big,
}

/// A number or a list of numbers in each element of a kind.
pub(super) struct Property {
    pub name: String,
    /// Type of the length of a list.
    pub list: Option<SampleType>,
    pub kind: SampleType,
}

/// Kind of elements.
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    /// Index and type of a property that is a number.
    pub fn scalar(&self, name: &str) -> Option<(usize, SampleType)> {
        let place = self.find(&[name], false)?;
        Some((place, self.properties[place].kind))
    }

    /// Index of a property.
    pub fn find(&self, names: &[&str], is_list: bool) -> Option<usize> {
        self.properties.iter().position(|p| names.contains(&p.name.as_str()) && p.list.is_some() == is_list)
    }
}

pub(super) struct PlyHeader {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
}

impl PlyHeader {
    /// Reads up to `end_header`.
    pub fn read(source: &mut Source) -> Result<PlyHeader, ShapeError> {
        let (mut line, mut encoding, mut elements) = (Vec::new(), None, Vec::<Element>::new());
        source.next_line(&mut line)?;
        if line.trim_ascii_end() != b"ply" {
            return Err(source.malformed("`ply`", &line));
        }
        loop {
            if !source.next_line(&mut line)? {
                return Err(source.ended("`end_header`"));
            }
            let words: Vec<&[u8]> = tokens(&line).collect();
            match words[..] {
                [] | [b"comment" | b"obj_info", ..] => {}
                [b"end_header"] => break,
                [b"format", name, b"1.0"] if encoding.is_none() => {
                    encoding = match name {
                        b"ascii" => Some(Encoding::Text),
                        b"binary_little_endian" => Some(Encoding::Little),
                        b"binary_big_endian" => Some(Encoding::Big),
                        _ => {
                            let expected = "`ascii`, `binary_little_endian` or `binary_big_endian`";
                            return Err(source.malformed(expected, name));
                        }
                    };
                }
                [b"element", name, count] => {
                    let count = number(count).ok_or_else(|| source.malformed("`element NAME COUNT`", &line))?;
                    let name = String::from_utf8_lossy(name).into_owned();
                    elements.push(Element { name, count, properties: Vec::new() });
                }
                [b"property", .., name] => {
                    let types = words[1..words.len() - 1].iter().filter(|word| **word != b"list");
                    let types: Option<Vec<SampleType>> = types.map(|word| number_type(word)).collect();
                    let (list, kind) = match (words[1] == b"list", types.as_deref()) {
                        (false, Some([kind])) => (None, *kind),
                        (true, Some([length, kind])) => (Some(*length), *kind),
                        _ => {
                            return Err(
                                source.malformed("`property TYPE NAME` or `property list TYPE TYPE NAME`", &line)
                            );
                        }
                    };
                    let Some(element) = elements.last_mut() else {
                        return Err(source.malformed("an `element` before its properties", &line));
                    };
                    element.properties.push(Property { name: String::from_utf8_lossy(name).into_owned(), list, kind });
                }
                _ => return Err(source.malformed("a line of a PLY header", &line)),
            }
        }
        let encoding = encoding
            .ok_or_else(|| source.malformed_at(Location::Header, "`format ascii 1.0` or another", "nothing".into()))?;
        Ok(PlyHeader { encoding, elements })
    }
}
