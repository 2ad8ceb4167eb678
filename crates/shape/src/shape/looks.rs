//! Normals and colors of the vertices of a mesh.

use super::Mesh;
use glam::{DVec3, Vec3};

/// Normal and color of each vertex of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Looks {
    /// Unit vectors outward; empty if there are none.
    pub normals: Vec<Vec3>,
    /// Linear RGB in \[0, 1\].
    pub colors: Vec<[f32; 3]>,
}

impl Looks {
    /// The color of a vertex in sRGB, \[0, 1\].
    pub(crate) fn srgb(&self, vertex: usize) -> [f32; 3] {
        self.colors[vertex].map(|linear| match linear.clamp(0.0, 1.0) {
            low if low <= 0.003_130_8 => 12.92 * low,
            high => 1.055 * high.powf(1.0 / 2.4) - 0.055,
        })
    }
}

/// A channel of a color within \[0, 1\]; 0 for NaN.
pub(crate) fn channel(value: f64) -> f32 {
    if value > 0.0 { value.min(1.0) as f32 } else { 0.0 }
}

/// Full scale of color channels whose file declares none: 1, or that of the codes that values above 1 must be. The second value is
/// a note about this assumption.
pub(crate) fn full_scale(colors: &[[f32; 3]]) -> (f64, Option<String>) {
    let all = colors.as_flattened();
    let largest = all.iter().copied().fold(0.0, f32::max);
    let are_whole = || all.iter().all(|value| value.fract() == 0.0);
    let codes = [255.0, 65_535.0, u32::MAX as f32].into_iter().find(|full| largest <= *full);
    match codes {
        _ if largest <= ALMOST_ONE => (1.0, None),
        Some(full) if largest > 2.0 || are_whole() => {
            (full.into(), Some(format!("colors reach {largest}: read as codes of 0 to {full}")))
        }
        _ => (1.0, Some(format!("colors reach {largest}: values above 1 count as 1"))),
    }
}

/// The largest value of a channel that is 1 but for rounding.
const ALMOST_ONE: f32 = 1.001;

/// Linear light of a channel in sRGB.
pub(crate) fn linear(code: f64) -> f32 {
    let code = channel(code);
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

impl Mesh {
    /// Unit normal of each vertex: the mean of its triangles' by their angles (Thürmer and Wüthrich 1998); 0 without triangles.
    pub fn vertex_normals(&self) -> Vec<Vec3> {
        let mut normals = vec![DVec3::ZERO; self.positions.len()];
        for (index, triangle) in self.triangles.iter().enumerate() {
            let corners = self.corners(index).map(Vec3::as_dvec3);
            for at in 0..3 {
                let [here, next, last] = [0, 1, 2].map(|more| corners[(at + more) % 3]);
                let (a, b) = (next - here, last - here);
                let normal = a.cross(b);
                normals[triangle[at] as usize] += normal.normalize_or_zero() * normal.length().atan2(a.dot(b));
            }
        }
        normals.into_iter().map(|normal| normal.normalize_or_zero().as_vec3()).collect()
    }
}
