//! A human head: face, ears, neck and skull as soft parts that blend into each other.
//!
//! Invariant: left and right are mirror images. Sources: PH 2.2 (soft objects are blended by their densities); I. Quilez,
//! "Smooth minimum", 2013 (the blend). Proportions of drawing schools: the eyes are halfway between chin and crown; chin to
//! nose, nose to brow and brow to hairline are a third of the face each.
//! Head units: eyes at y = 0, crown at 1, chin at -1, x across, face to +z.

use crate::shape::solid::ellipsoid_distance;
use crate::shape::{Content, Volume};
use Form::{Ellipsoid, Limb};
use glam::{Mat3, Vec3};
use rayon::prelude::*;

/// Samples along the height: eyelids and nostrils are 2 voxels wide.
const SIZE: u32 = 192;
/// Corners of the volume in head units, with a margin around the surface.
const LOW: Vec3 = Vec3::new(-0.86, -1.48, -0.98);
const HIGH: Vec3 = Vec3::new(0.86, 1.03, 0.96);
/// Half width of the ramp of values at the skin, in samples. Lower rounds off the surface.
const RAMP: f32 = 4.0;

/// The iso-value of the skin.
pub const SKIN: f32 = 0.5;

/// Soft part of the half with positive x.
struct HeadPart {
    form: Form,
    /// Width of the blend with the parts before it.
    blend: f32,
    /// Whether the part is subtracted.
    carve: bool,
}

/// Points computed per vector operation.
const LANES: usize = 16;

/// Shape of a part, in head units.
enum Form {
    /// Center, half axes, and rotations about x (top backward) and then y (front outward) in degrees.
    Ellipsoid([f32; 3], [f32; 3], [f32; 2]),
    /// Two ends with their radii.
    Limb([f32; 3], [f32; 3], [f32; 2]),
}

const fn add(blend: f32, form: Form) -> HeadPart {
    HeadPart { form, blend, carve: false }
}

const fn carve(blend: f32, form: Form) -> HeadPart {
    HeadPart { form, blend, carve: true }
}

/// No rotation.
const LEVEL: [f32; 2] = [0.0; 2];

/// Parts of the skin; each blends with all before it.
const PARTS: &[HeadPart] = &[
    // Skull and face.
    add(0.0, Ellipsoid([0.0, 0.27, -0.14], [0.69, 0.72, 0.80], LEVEL)),
    add(0.20, Ellipsoid([0.0, 0.24, 0.16], [0.57, 0.54, 0.54], LEVEL)),
    add(0.20, Ellipsoid([0.0, -0.22, 0.14], [0.58, 0.64, 0.53], LEVEL)),
    add(0.20, Limb([0.0, -0.50, 0.20], [0.0, -0.78, 0.38], [0.40, 0.20])),
    add(0.20, Limb([0.40, -0.42, 0.02], [0.14, -0.84, 0.42], [0.12, 0.10])),
    add(0.12, Ellipsoid([0.0, -0.85, 0.50], [0.19, 0.14, 0.16], LEVEL)),
    add(0.20, Ellipsoid([0.35, -0.20, 0.41], [0.20, 0.13, 0.20], LEVEL)),
    carve(0.25, Ellipsoid([0.88, 0.14, 0.58], [0.24, 0.30, 0.30], LEVEL)),
    // Brow, eye sockets, lids, eyes.
    add(0.20, Limb([0.0, 0.15, 0.58], [0.40, 0.18, 0.47], [0.09, 0.06])),
    carve(0.12, Ellipsoid([0.26, 0.00, 0.74], [0.17, 0.11, 0.17], LEVEL)),
    carve(0.08, Ellipsoid([0.14, 0.01, 0.74], [0.06, 0.10, 0.13], LEVEL)),
    add(0.05, Ellipsoid([0.255, 0.0, 0.475], [0.170, 0.160, 0.165], LEVEL)),
    carve(0.02, Ellipsoid([0.26, -0.012, 0.66], [0.130, 0.068, 0.17], [0.0, 20.0])),
    add(0.0, Ellipsoid([0.255, 0.0, 0.475], [0.14, 0.135, 0.137], LEVEL)),
    carve(0.02, Ellipsoid([0.255, 0.0, 0.635], [0.038, 0.038, 0.045], LEVEL)),
    // Nose.
    add(0.10, Limb([0.0, 0.12, 0.61], [0.0, -0.28, 0.80], [0.060, 0.070])),
    add(0.06, Ellipsoid([0.0, -0.30, 0.80], [0.090, 0.085, 0.10], LEVEL)),
    add(0.06, Ellipsoid([0.100, -0.340, 0.715], [0.062, 0.058, 0.09], LEVEL)),
    carve(0.03, Ellipsoid([0.056, -0.410, 0.765], [0.030, 0.045, 0.045], LEVEL)),
    // Mouth and chin.
    add(0.18, Ellipsoid([0.0, -0.57, 0.49], [0.30, 0.22, 0.22], LEVEL)),
    carve(0.06, Limb([0.0, -0.46, 0.765], [0.0, -0.50, 0.760], [0.016, 0.018])),
    add(0.035, Ellipsoid([0.050, -0.540, 0.660], [0.165, 0.060, 0.105], [0.0, 20.0])),
    add(0.035, Ellipsoid([0.030, -0.648, 0.655], [0.150, 0.072, 0.105], [0.0, 14.0])),
    carve(0.035, Ellipsoid([0.0, -0.592, 0.70], [0.175, 0.012, 0.13], LEVEL)),
    carve(0.10, Ellipsoid([0.0, -0.755, 0.76], [0.16, 0.040, 0.06], LEVEL)),
    // Neck.
    add(0.16, Limb([0.0, -0.55, -0.20], [0.0, -1.7, -0.34], [0.38, 0.42])),
    add(0.14, Limb([0.48, -0.38, -0.24], [0.13, -1.55, 0.08], [0.08, 0.10])),
    add(0.14, Ellipsoid([0.0, -1.10, 0.10], [0.07, 0.11, 0.08], LEVEL)),
    // Ears: a bowl, and the ridge before it.
    add(0.05, Ellipsoid([0.72, -0.06, -0.12], [0.065, 0.25, 0.155], [14.0, -22.0])),
    carve(0.05, Ellipsoid([0.80, -0.01, -0.105], [0.060, 0.175, 0.095], [14.0, -22.0])),
    add(0.05, Limb([0.735, 0.09, -0.13], [0.74, -0.12, -0.15], [0.022, 0.030])),
    carve(0.04, Ellipsoid([0.745, -0.06, -0.06], [0.050, 0.075, 0.045], LEVEL)),
];

/// Parts of the skull, which is cut off at [`FLESH`] below the skin.
const SKULL: &[HeadPart] = &[
    // Braincase and face.
    add(0.0, Ellipsoid([0.0, 0.26, -0.14], [0.62, 0.65, 0.73], LEVEL)),
    add(0.15, Ellipsoid([0.0, 0.22, 0.14], [0.50, 0.48, 0.48], LEVEL)),
    add(0.12, Ellipsoid([0.0, -0.22, 0.32], [0.30, 0.30, 0.33], LEVEL)),
    carve(0.12, Ellipsoid([0.66, 0.04, 0.24], [0.15, 0.24, 0.17], LEVEL)),
    // Brow, cheekbones and their arches to the ears.
    add(0.08, Limb([0.05, 0.17, 0.60], [0.40, 0.14, 0.48], [0.07, 0.06])),
    add(0.05, Limb([0.40, 0.14, 0.48], [0.40, -0.14, 0.46], [0.055, 0.07])),
    add(0.05, Limb([0.40, -0.14, 0.46], [0.63, -0.10, 0.02], [0.07, 0.04])),
    // Eye sockets, nose.
    carve(0.05, Ellipsoid([0.235, 0.0, 0.62], [0.145, 0.125, 0.26], LEVEL)),
    add(0.04, Limb([0.0, 0.12, 0.56], [0.0, -0.08, 0.66], [0.045, 0.035])),
    carve(0.03, Ellipsoid([0.045, -0.26, 0.66], [0.065, 0.13, 0.20], LEVEL)),
    // The hollow of the brain, and that behind the teeth.
    carve(0.04, Ellipsoid([0.0, 0.33, -0.18], [0.53, 0.51, 0.60], LEVEL)),
    carve(0.05, Ellipsoid([0.0, -0.58, 0.08], [0.25, 0.26, 0.34], LEVEL)),
    // Teeth, and the jaw below them.
    add(0.03, Ellipsoid([0.0, -0.46, 0.40], [0.21, 0.095, 0.21], LEVEL)),
    add(0.03, Ellipsoid([0.0, -0.63, 0.39], [0.20, 0.095, 0.20], LEVEL)),
    add(0.05, Ellipsoid([0.0, -0.80, 0.44], [0.17, 0.10, 0.13], LEVEL)),
    add(0.06, Limb([0.10, -0.80, 0.42], [0.40, -0.60, 0.00], [0.09, 0.085])),
    add(0.05, Limb([0.40, -0.60, 0.00], [0.50, -0.12, -0.08], [0.08, 0.05])),
    carve(0.01, Ellipsoid([0.0, -0.545, 0.55], [0.40, 0.012, 0.30], LEVEL)),
    carve(0.02, Ellipsoid([0.0, -0.62, 0.06], [0.14, 0.30, 0.36], LEVEL)),
    // Spine.
    add(0.04, Limb([0.0, -0.36, -0.24], [0.0, -1.7, -0.32], [0.13, 0.15])),
];

/// Least depth of bone below the skin. Lower: a voxel between them could belong to both.
const FLESH: f32 = 0.055;
/// Half width of the ramp of values at the bone, in samples.
const RAMP_OF_BONE: f32 = 2.0;

/// Height of the cut through the neck.
const NECK_END: f32 = -1.45;

/// Distance to a segment whose radius varies linearly.
#[inline(always)]
fn limb(p: Vec3, a: Vec3, b: Vec3, [ra, rb]: [f32; 2]) -> f32 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    p.distance(a + t * along) - (ra + t * (rb - ra))
}

/// Smooth minimum: rounded off where the distances differ by less than `width`.
#[inline(always)]
fn blend(a: f32, b: f32, width: f32) -> f32 {
    let h = (1.0 - (a - b).abs() / width.max(1e-6)).max(0.0);
    a.min(b) - 0.25 * width * h * h
}

/// Inverse rotation of each part.
fn turns(parts: &[HeadPart]) -> Vec<Mat3> {
    let of = |part: &HeadPart| match part.form {
        Ellipsoid(_, _, [back, out]) => {
            Mat3::from_rotation_x(back.to_radians()) * Mat3::from_rotation_y(-out.to_radians())
        }
        Limb(..) => Mat3::IDENTITY,
    };
    parts.iter().map(of).collect()
}

/// First-order signed distances to the parts in head units for a row of points, positive outside; lower bounds at blends.
#[inline(always)] // for the vector instructions of this processor
fn distances(x: [f32; LANES], [y, z]: [f32; 2], parts: &[HeadPart], turns: &[Mat3]) -> [f32; LANES] {
    let (mut soft, mut own) = ([f32::MAX; LANES], [0.0; LANES]);
    for (part, turn) in parts.iter().zip(turns) {
        match part.form {
            Ellipsoid(center, axes, _) => {
                for lane in 0..LANES {
                    let away = Vec3::new(x[lane].abs(), y, z) - Vec3::from(center);
                    own[lane] = ellipsoid_distance(*turn * away, Vec3::from(axes));
                }
            }
            Limb(a, b, radii) => {
                for lane in 0..LANES {
                    own[lane] = limb(Vec3::new(x[lane].abs(), y, z), Vec3::from(a), Vec3::from(b), radii);
                }
            }
        }
        let sign = if part.carve { -1.0 } else { 1.0 };
        for lane in 0..LANES {
            soft[lane] = sign * blend(sign * soft[lane], own[lane], part.blend);
        }
    }
    soft.map(|soft| -blend(-soft, y - NECK_END, 0.1))
}

/// Half of a row of samples with negative x; `low` is the first point.
struct HalfRow<'a> {
    low: Vec3,
    step: f32,
    parts: [(&'a [HeadPart], &'a [Mat3]); 2],
    values: &'a mut [f32],
}

impl pulp::NullaryFnOnce for HalfRow<'_> {
    type Output = ();

    #[inline(always)] // like all callees
    fn call(self) {
        let HalfRow { low, step, parts: [skin, bone], values } = self;
        let ramp = |distance: f32, samples: f32| (0.5 - 0.5 * distance / (samples * step)).clamp(0.0, 1.0);
        for (chunk, values) in values.chunks_mut(LANES).enumerate() {
            let x = std::array::from_fn(|lane| low.x + step * (chunk * LANES + lane) as f32);
            let skin = distances(x, [low.y, low.z], skin.0, skin.1);
            let bone = if skin.iter().any(|skin| *skin < 0.0) {
                distances(x, [low.y, low.z], bone.0, bone.1)
            } else {
                [f32::MAX; LANES]
            };
            for ((value, skin), bone) in values.iter_mut().zip(skin).zip(bone) {
                let bone = if skin < 0.0 { bone.max(skin + FLESH) } else { f32::MAX };
                *value = ramp(skin, RAMP) + ramp(bone, RAMP_OF_BONE);
            }
        }
    }
}

/// The head: scalars 0 outside, 1 in the flesh, 2 in the bone, like a scan; the skin is at [`SKIN`], the bone at 1.5.
/// Fits into [-1, 1]^3, face towards +z.
pub fn head() -> Volume {
    let scale = 2.0 / (HIGH - LOW).max_element();
    let step = (HIGH - LOW).max_element() / (SIZE - 1) as f32;
    let size = ((HIGH - LOW) / step).floor().as_uvec3() + 1;
    let low = 0.5 * (LOW + HIGH - step * (size - 1).as_vec3()); // in the middle, so that left and right are alike
    let [nx, ny, nz] = size.to_array().map(|n| n as usize);
    let (turns, turns_of_bone, arch) = (turns(PARTS), turns(SKULL), pulp::Arch::new());
    let mut values = vec![0.0; nx * ny * nz];
    values.par_chunks_mut(nx).enumerate().for_each(|(row, values)| {
        let half = nx.div_ceil(2);
        let low = low + step * Vec3::new(0.0, (row % ny) as f32, (row / ny) as f32);
        let parts = [(PARTS, turns.as_slice()), (SKULL, turns_of_bone.as_slice())];
        arch.dispatch(HalfRow { low, step, parts, values: &mut values[..half] });
        (0..half).for_each(|x| values[nx - 1 - x] = values[x]);
    });
    let origin = scale * (low - 0.5 * (LOW + HIGH));
    let steps = Mat3::from_diagonal(Vec3::splat(scale * step));
    Volume { size: size.to_array(), origin, steps, values, content: Content::Scalar }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(p: Vec3, parts: &[HeadPart], turns: &[Mat3]) -> f32 {
        distances([p.x; LANES], [p.y, p.z], parts, turns)[0]
    }

    /// Depth of the surface along -z at a point of the face, head units.
    fn relief(parts: &[HeadPart], x: f32, y: f32) -> f32 {
        let turns = turns(parts);
        let is_in = |z: &f32| distance(Vec3::new(x, y, *z), parts, &turns) <= 0.0;
        (0..2000).map(|i| 1.2 - i as f32 * 1e-3).find(is_in).unwrap_or(-1.0)
    }

    #[test]
    fn the_face_has_its_features_where_they_belong() {
        let relief = |x, y| relief(PARTS, x, y);
        let (tip, brow, eye) = (relief(0.0, -0.3), relief(0.2, 0.17), relief(0.26, 0.03));
        assert!(tip > brow + 0.15 && brow > eye + 0.05, "{tip} {brow} {eye}");
        let (upper, between, lower) = (relief(0.0, -0.54), relief(0.0, -0.59), relief(0.0, -0.65));
        assert!(upper > between + 0.01 && lower > between + 0.01 && upper < tip, "{upper} {between} {lower}");
        let (under, chin) = (relief(0.0, -0.76), relief(0.0, -0.87));
        assert!(under < lower && under < chin + 0.02, "{under} {chin}");
        // Ears stand off at the height of eyes and nose; above and below them the head is narrower.
        let solid = |x: f32, y: f32| distance(Vec3::new(x, y, -0.15), PARTS, &turns(PARTS)) <= 0.0;
        let wide = |y: f32| (0..1000).map(|i| 1.0 - i as f32 * 1e-3).find(|&x| solid(x, y));
        let [above, ear, below] = [0.5, 0.0, -0.6].map(|y| wide(y).unwrap());
        assert!(ear > above + 0.08 && ear > below + 0.15, "{above} {ear} {below}");
    }

    #[test]
    fn the_head_surface_follows_its_parts_inside_the_border() {
        let head = head();
        let [nx, ny, nz] = head.size.map(|n| n as usize);
        let value = |x: usize, y: usize, z: usize| head.values[(z * ny + y) * nx + x];
        let border = |x, y, z| x == 0 || y == 0 || z == 0 || x == nx - 1 || y == ny - 1 || z == nz - 1;
        for (z, y, x) in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (z, y, x)))) {
            assert!(!border(x, y, z) || value(x, y, z) < SKIN, "{x} {y} {z}");
            assert!((value(x, y, z) - value(nx - 1 - x, y, z)).abs() < 1e-3, "{x} {y} {z} is not mirrored");
        }
        assert_eq!(head.range(), (0.0, 2.0));
    }

    #[test]
    fn the_skull_lies_in_the_flesh_and_has_its_hollows() {
        let head = head();
        let step = f64::from(head.steps.x_axis.x);
        let wall = |a: f32, b: f32| (a > 1.0) != (b > 1.0) && (a < 0.5 || b < 0.5);
        let [nx, ny, _] = head.size.map(|n| n as usize);
        for (index, value) in head.values.iter().enumerate() {
            for stride in [1, nx, nx * ny] {
                let next = head.values.get(index + stride).copied().unwrap_or(0.0);
                assert!(!wall(*value, next), "skin and bone within {step}");
            }
        }
        let relief = |x, y| relief(SKULL, x, y);
        assert!(relief(0.24, 0.0) < relief(0.24, 0.17) - 0.2, "eye socket");
        assert!(relief(0.05, -0.25) < relief(0.0, -0.46) - 0.1, "nose");
        let turns = turns(SKULL);
        let is_bone = |x: f32, y: f32, z: f32| distance(Vec3::new(x, y, z), SKULL, &turns) <= 0.0;
        assert!(!is_bone(0.0, 0.3, -0.1) && is_bone(0.0, 0.3, -0.83), "braincase");
    }
}
