//! Node hierarchy of a glTF scene.
//!
//! Invariant: a node is visited once; mirrored meshes are reversed so that they stay wound outward.

use super::buffer::Data;
use super::document::{Document, Node, entry, malformed};
use super::material::Materials;
use super::primitive::MeshPart;
use crate::error::ShapeError;
use crate::shape::paint::Spot;
use crate::source::{Source, check_positions};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, DVec4};

/// Tolerance of the length of a rotation: numbers of three digits.
const MAX_LENGTH_ERROR: f64 = 0.01;

/// Tolerance of the last row of a matrix.
const MAX_ROW_ERROR: f64 = 1e-3;

/// All triangles of a scene.
pub(crate) struct SceneMesh {
    pub positions: Vec<DVec3>,
    /// Linear RGB of each position; empty without colors.
    pub colors: Vec<[f32; 3]>,
    /// Spots of the positions; empty unless materials are asked for.
    pub spots: Vec<Spot>,
    pub triangles: Vec<[u32; 3]>,
    /// Dropped triangles.
    pub zero_area: usize,
    pub notes: Vec<String>,
}

/// Stack of nodes to visit.
struct Visits<'a, 's> {
    source: &'a Source<'s>,
    document: &'a Document<'a>,
    /// Nodes with the transforms of their parents.
    nodes: Vec<(u32, DAffine3)>,
    /// Whether each node was ever in `nodes`.
    named: Vec<bool>,
}

impl Visits<'_, '_> {
    /// Pushes nodes, the first one on top; a repeated node is an error.
    fn add(&mut self, nodes: &[u32], parent: DAffine3, place: impl Fn(usize) -> String) -> Result<(), ShapeError> {
        let before = self.nodes.len();
        for (at, &node) in nodes.iter().enumerate() {
            entry(self.source, &self.document.nodes, node, || place(at))?;
            if std::mem::replace(&mut self.named[node as usize], true) {
                return Err(malformed(self.source, place(at), "each node once in a tree", format!("{node} again")));
            }
            self.nodes.push((node, parent));
        }
        self.nodes[before..].reverse();
        Ok(())
    }

    /// Pushes the roots of the default scene, else of the first, else all nodes without a parent.
    fn begin(&mut self) -> Result<(), ShapeError> {
        let (source, document) = (self.source, self.document);
        if document.scene.is_some() || !document.scenes.is_empty() {
            let index = document.scene.unwrap_or(0);
            let scene = entry(source, &document.scenes, index, || "scene".into())?;
            return self.add(&scene.nodes, DAffine3::IDENTITY, |at| format!("scenes[{index}].nodes[{at}]"));
        }
        let mut is_child = vec![false; document.nodes.len()];
        for child in document.nodes.iter().flat_map(|node| &node.children) {
            if let Some(own) = is_child.get_mut(*child as usize) {
                *own = true;
            }
        }
        let roots: Vec<u32> = (0..document.nodes.len() as u32).filter(|&node| !is_child[node as usize]).collect();
        if roots.is_empty() && !document.nodes.is_empty() {
            return Err(malformed(source, "nodes".into(), "a node without a parent", "circles only"));
        }
        self.add(&roots, DAffine3::IDENTITY, |at| format!("nodes[{}]", roots[at]))
    }
}

/// Reads the triangles of the default scene, else of the first, else of all nodes.
pub fn read(data: &Data, materials: Option<&Materials>) -> Result<SceneMesh, ShapeError> {
    let (source, document) = (data.source, data.document);
    let mut visits = Visits { source, document, nodes: Vec::new(), named: vec![false; document.nodes.len()] };
    visits.begin()?;
    let mut parts: Vec<Option<MeshPart>> = document.meshes.iter().map(|_| None).collect();
    let (mut shown, mut declared, mut counts) = (Vec::new(), 0, [0; 9]);
    let (mut triangles, mut positions) = (0, 0);
    counts[8] = document.animations.len();
    while let Some((index, parent)) = visits.nodes.pop() {
        let node = &document.nodes[index as usize];
        if node.extensions.hides() {
            counts[7] += 1;
            continue;
        }
        let world = parent * local(data, index, node)?;
        visits.add(&node.children, world, |at| format!("nodes[{index}].children[{at}]"))?;
        let Some(mesh) = node.mesh else { continue };
        entry(source, &document.meshes, mesh, || format!("nodes[{index}].mesh"))?;
        node.extensions.check((data.source, data.document), false, || format!("nodes[{index}]"))?;
        let slot = &mut parts[mesh as usize];
        let part = match slot {
            Some(part) => part,
            None => slot.insert(MeshPart::read((data, materials), mesh, &mut declared)?),
        };
        (triangles, positions) = (triangles + part.triangles.len(), positions + part.positions.len());
        source.check_triangles(triangles as u64)?;
        // glTF 3.7.3.2: joints place a skinned mesh, its node does not.
        let world = if node.skin.is_some() { DAffine3::IDENTITY } else { world };
        check_positions(&source.file, "vertices", &part.at(world).collect::<Vec<_>>())?;
        shown.push((mesh, world));
        let left_out = [
            part.points_and_lines,
            part.without_positions,
            part.leftover_corners,
            usize::from(node.skin.is_some()),
            usize::from(part.morphs),
            part.empty,
            part.masked,
        ];
        counts.iter_mut().zip(left_out).for_each(|(count, more)| *count += more);
    }
    let texts = [
        "primitives of points or lines are left out",
        "primitives without positions are left out",
        "corners of incomplete triangles are left out",
        "skins are not applied, their meshes keep the pose in which they were bound",
        "morph targets are not applied, their meshes keep their base shape",
        "primitives without vertices or indices are left out",
        "cut-outs by alphaMode MASK are not applied, their primitives stay whole",
        "hidden nodes are left out, with all below them",
        "animations are not played, nodes stand where they are at rest",
    ];
    let mut found = SceneMesh {
        positions: Vec::with_capacity(positions),
        colors: Vec::new(),
        spots: Vec::new(),
        triangles: Vec::with_capacity(triangles),
        zero_area: 0,
        notes: Vec::new(),
    };
    for (mesh, world) in shown {
        parts[mesh as usize].iter().for_each(|part| found.add(part, world));
    }
    if !parts.iter().flatten().any(|part| part.is_colored) {
        found.colors.clear();
    }
    let notes = texts.iter().zip(counts).filter(|(_, count)| *count > 0);
    found.notes = notes.map(|(text, count)| format!("{text}: {count}")).collect();
    Ok(found)
}

impl SceneMesh {
    /// Adds a mesh with a transform.
    fn add(&mut self, part: &MeshPart, world: DAffine3) {
        let (first, mirrored) = (self.positions.len() as u32, world.matrix3.determinant() < 0.0);
        self.positions.extend(part.at(world));
        self.colors.extend(&part.colors);
        self.spots.extend(&part.spots);
        self.triangles.extend(part.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|corner| first + corner);
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
        self.zero_area += part.zero_area;
    }
}

/// Transform from a node to its parent.
fn local(data: &Data, index: u32, node: &Node) -> Result<DAffine3, ShapeError> {
    let refuse = |field: &str, expected, found: String| {
        Err(malformed(data.source, format!("nodes[{index}].{field}"), expected, found))
    };
    let is_split = node.translation.is_some() || node.rotation.is_some() || node.scale.is_some();
    if let Some(matrix) = &node.matrix {
        if is_split {
            return refuse("matrix", "either a matrix or its parts", "both".into());
        }
        let matrix = DMat4::from_cols_array(matrix);
        // Rounding of products of matrices in f32.
        let off = (matrix.row(3) - DVec4::W).abs().max_element();
        if off.is_nan() || off > MAX_ROW_ERROR {
            return refuse("matrix", "0, 0, 0, 1 as its last row", format!("{:?}", matrix.row(3).to_array()));
        }
        return Ok(DAffine3::from_mat4(matrix));
    }
    let rotation = match node.rotation.as_deref() {
        None => DQuat::IDENTITY,
        Some(&xyzw) => {
            let rotation = DQuat::from_array(xyzw);
            if xyzw == [0.0; 4] {
                data.source.note("rotations of 0, 0, 0, 0 are read as none".into());
                DQuat::IDENTITY
            } else if (rotation.length() - 1.0).abs() > MAX_LENGTH_ERROR {
                return refuse("rotation", "a rotation of length 1", format!("{xyzw:?}"));
            } else {
                rotation.normalize()
            }
        }
    };
    let scale = DVec3::from(node.scale.as_deref().copied().unwrap_or([1.0; 3]));
    let translation = DVec3::from(node.translation.as_deref().copied().unwrap_or_default());
    let matrix3 = DMat3::from_quat(rotation) * DMat3::from_diagonal(scale);
    Ok(DAffine3 { matrix3, translation })
}
