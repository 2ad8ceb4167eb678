//! Writers of meshes.
//!
//! Invariant: a mesh is read back bit for bit; in formats without an offset, coordinates are rounded to the format.
//! Sources: 3D Systems, "StereoLithography Interface Specification", 1989; G. Turk, "The PLY Polygon File Format", 1994;
//! Wavefront, "Object Files", 1995; Khronos, "glTF 2.0 Specification".

use super::checked::{check, places};
use super::threemf::{PrintBody, PrintFile};
use crate::shape::Mesh;
use crate::shape::looks::Looks;
use glam::DVec3;
use serde_json::json;
use std::io::{self, Write};
use std::path::Path;

/// File format of written meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Binary STL: triangles without shared corners.
    Stl,
    /// Binary PLY, little endian: floats, or doubles where the mesh has an offset.
    Ply,
    /// Wavefront OBJ, with as many digits as coordinates have.
    Obj,
    /// Binary glTF 2.0; an offset becomes the translation of the node.
    Glb,
    /// 3MF in millimeters, with one body.
    ThreeMf,
}

impl MeshFormat {
    const ENDS: [(MeshFormat, &'static str); 5] = [
        (MeshFormat::Stl, "stl"),
        (MeshFormat::Ply, "ply"),
        (MeshFormat::Obj, "obj"),
        (MeshFormat::Glb, "glb"),
        (MeshFormat::ThreeMf, "3mf"),
    ];

    /// Format by extension: .stl, .ply, .obj, .glb or .3mf, in any case.
    pub fn from_path(path: &Path) -> Option<MeshFormat> {
        let own = path.extension()?;
        MeshFormat::ENDS.iter().find(|(_, end)| own.eq_ignore_ascii_case(end)).map(|(format, _)| *format)
    }

    /// Writes a mesh with at least one triangle, at most 2^32 - 1 corners and finite coordinates.
    ///
    /// # Errors
    /// Errors of `to`, and `InvalidInput` for any other mesh.
    pub fn write(&self, mesh: &Mesh, to: impl Write) -> io::Result<()> {
        self.write_with(mesh, None, to)
    }

    /// Whether the format stores colors of vertices.
    pub fn has_colors(&self) -> bool {
        *self != MeshFormat::Stl
    }

    /// Writes a mesh with the normals, if there are any, and colors of its vertices; STL has neither, 3MF no normals. Colors are bytes
    /// of sRGB in PLY and 3MF, sRGB in OBJ, and linear in glTF.
    ///
    /// # Errors
    /// As [`MeshFormat::write`], and `InvalidInput` unless each vertex has a look.
    pub fn write_with(&self, mesh: &Mesh, looks: Option<&Looks>, mut to: impl Write) -> io::Result<()> {
        check(mesh, looks)?;
        match self {
            MeshFormat::Stl => write_stl(mesh, &mut to),
            MeshFormat::Ply => write_ply(mesh, looks, &mut to),
            MeshFormat::Obj => write_obj(mesh, looks, &mut to),
            MeshFormat::Glb => write_glb(mesh, looks, &mut to),
            MeshFormat::ThreeMf => {
                let bodies = &[PrintBody { name: "", mesh, looks }];
                PrintFile { bodies, ..PrintFile::default() }.write(&mut to)
            }
        }?;
        to.flush()
    }
}

fn write_floats(numbers: &[f32], to: &mut impl Write) -> io::Result<()> {
    numbers.iter().try_for_each(|number| to.write_all(&number.to_le_bytes()))
}

fn write_stl(mesh: &Mesh, to: &mut impl Write) -> io::Result<()> {
    let count = u32::try_from(mesh.triangles.len()).map_err(io::Error::other)?;
    to.write_all(&[b' '; 80])?;
    to.write_all(&count.to_le_bytes())?;
    for index in 0..mesh.triangles.len() {
        let corners = mesh.corners(index);
        let [a, b, c] = corners.map(|corner| corner.as_dvec3());
        let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
        let places = corners.map(|corner| (corner.as_dvec3() + mesh.offset).as_vec3());
        [normal, places[0], places[1], places[2]].iter().try_for_each(|vector| write_floats(&vector.to_array(), to))?;
        to.write_all(&[0; 2])?; // attributes
    }
    Ok(())
}

fn write_ply(mesh: &Mesh, looks: Option<&Looks>, to: &mut impl Write) -> io::Result<()> {
    let is_far = mesh.offset != DVec3::ZERO;
    let kind = if is_far { "double" } else { "float" };
    writeln!(to, "ply\nformat binary_little_endian 1.0\nelement vertex {}", mesh.positions.len())?;
    ["x", "y", "z"].iter().try_for_each(|axis| writeln!(to, "property {kind} {axis}"))?;
    let normals = looks.map_or(&[][..], |looks| &looks.normals);
    if !normals.is_empty() {
        ["nx", "ny", "nz"].iter().try_for_each(|axis| writeln!(to, "property float {axis}"))?;
    }
    if looks.is_some() {
        ["red", "green", "blue"].iter().try_for_each(|channel| writeln!(to, "property uchar {channel}"))?;
    }
    writeln!(to, "element face {}\nproperty list uchar uint vertex_indices\nend_header", mesh.triangles.len())?;
    for (index, (near, far)) in mesh.positions.iter().zip(places(mesh)).enumerate() {
        if is_far {
            far.to_array().iter().try_for_each(|number| to.write_all(&number.to_le_bytes()))?
        } else {
            write_floats(&near.to_array(), to)?
        }
        if let Some(normal) = normals.get(index) {
            write_floats(&normal.to_array(), to)?;
        }
        if let Some(looks) = looks {
            to.write_all(&looks.srgb(index).map(|channel| (255.0 * channel).round() as u8))?;
        }
    }
    for triangle in &mesh.triangles {
        to.write_all(&[3])?;
        triangle.iter().try_for_each(|corner| to.write_all(&corner.to_le_bytes()))?;
    }
    Ok(())
}

fn write_obj(mesh: &Mesh, looks: Option<&Looks>, to: &mut impl Write) -> io::Result<()> {
    let is_far = mesh.offset != DVec3::ZERO;
    for (index, (near, far)) in mesh.positions.iter().zip(places(mesh)).enumerate() {
        if is_far {
            write!(to, "v {} {} {}", far.x, far.y, far.z)?
        } else {
            write!(to, "v {} {} {}", near.x, near.y, near.z)?
        }
        match looks.map(|looks| looks.srgb(index)) {
            Some([red, green, blue]) => writeln!(to, " {red} {green} {blue}")?,
            None => writeln!(to)?,
        }
    }
    let normals = looks.iter().flat_map(|looks| &looks.normals);
    normals.clone().try_for_each(|normal| writeln!(to, "vn {} {} {}", normal.x, normal.y, normal.z))?;
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| u64::from(corner) + 1);
        match looks.filter(|looks| !looks.normals.is_empty()) {
            Some(_) => writeln!(to, "f {a}//{a} {b}//{b} {c}//{c}")?,
            None => writeln!(to, "f {a} {b} {c}")?,
        }
    }
    Ok(())
}

fn write_glb(mesh: &Mesh, looks: Option<&Looks>, to: &mut impl Write) -> io::Result<()> {
    let (vertices, indices) = (mesh.positions.len(), 3 * mesh.triangles.len());
    let (places, corners) = (12 * vertices as u64, 4 * indices as u64);
    let bounds = mesh.bounds();
    let mut node = json!({ "mesh": 0 });
    if mesh.offset != DVec3::ZERO {
        node["translation"] = json!(mesh.offset.to_array());
    }
    let mut attributes = json!({ "POSITION": 0 });
    let mut accessors = vec![
        json!({
            "bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3",
            "min": bounds.min.to_array(), "max": bounds.max.to_array(),
        }),
        json!({ "bufferView": 1, "componentType": 5125, "count": indices, "type": "SCALAR" }),
    ];
    let mut views = vec![
        json!({ "buffer": 0, "byteLength": places, "target": 34962 }),
        json!({ "buffer": 0, "byteOffset": places, "byteLength": corners, "target": 34963 }),
    ];
    let mut all = places + corners;
    let has_normals = looks.is_some_and(|looks| !looks.normals.is_empty());
    let names = [("NORMAL", has_normals), ("COLOR_0", looks.is_some())];
    for (name, _) in names.into_iter().filter(|(_, is_there)| *is_there) {
        attributes[name] = json!(views.len());
        accessors.push(json!({ "bufferView": views.len(), "componentType": 5126, "count": vertices, "type": "VEC3" }));
        views.push(json!({ "buffer": 0, "byteOffset": all, "byteLength": places, "target": 34962 }));
        all += places;
    }
    let document = json!({
        "asset": { "version": "2.0", "generator": "hypertexture" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [node],
        "meshes": [{ "primitives": [{ "attributes": attributes, "indices": 1 }] }],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": all }],
    });
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    // 12 bytes of header, and 8 before each chunk.
    let length = |bytes: u64| u32::try_from(bytes).map_err(|_| io::Error::other("a glTF file ends at 4 GiB"));
    let whole = length(28 + text.len() as u64 + all)?;
    to.write_all(b"glTF\x02\0\0\0")?;
    to.write_all(&whole.to_le_bytes())?;
    to.write_all(&(text.len() as u32).to_le_bytes())?;
    to.write_all(b"JSON")?;
    to.write_all(&text)?;
    to.write_all(&length(all)?.to_le_bytes())?;
    to.write_all(b"BIN\0")?;
    mesh.positions.iter().try_for_each(|place| write_floats(&place.to_array(), to))?;
    mesh.triangles.as_flattened().iter().try_for_each(|corner| to.write_all(&corner.to_le_bytes()))?;
    let Some(Looks { normals, colors }) = looks else { return Ok(()) };
    normals.iter().try_for_each(|normal| write_floats(&normal.to_array(), to))?;
    colors.iter().try_for_each(|color| write_floats(color, to))
}
