//! Classification of a point: premultiplied matter.

use crate::formulas::density::{bias, gain};
use crate::formulas::groom::{mixed, narrowed, painted};
use crate::formulas::harness::{At, COLOR, Check};
use crate::formulas::surface::transfer;
use crate::formulas::values::{Random, Setting, filtered};
use glam::{DMat3, DVec3};
use hypertexture::eval::Wrap;
use hypertexture::shader::Library;

crate::rows! {
    m10_p45_soft_matter_covers_by_its_modulated_density = |l| soft(l, CLASSIFY),
        "classify/soft.glsl": "if (hard)" => "if (!hard)",
        "classify/soft.glsl": "modulate(s.density, s)" => "s.density",
        "two_phases.glsl": "density >= 1.0" => "density >= 2.0";
    m10_p45_two_phases_find_what_one_does = |l| soft(l, IN_PHASES),
        "two_phases.glsl": "s.density = density_found" => "s.density = 0.5 * density_found";
    m30_a_hard_object_covers_or_does_not = surface,
        "classify/surface.glsl": "if (!hard)" => "if (hard)";
    m04_post_classification_looks_up_the_density = post,
        "classify/post.glsl": "matter.rgb * alpha" => "matter.rgb";
    m05_pre_classification_interpolates_colors = pre,
        "classify/pre.glsl": "matter.rgb / matter.a" => "matter.rgb";
    shells_are_painted_and_cut = |l| preintegrated(l, &[("classify", "preintegrated"), ("groom", "volume")]),
        "classify/preintegrated.glsl": "groom_depth(s.density, s.root)" => "groom_depth(s.density, s.x)",
        "classify/preintegrated.glsl": "matter.a * groom_color(" => "groom_color(";
    m05_pre_integration_looks_up_both_ends = |l| preintegrated(l, &[("classify", "preintegrated")]),
        "classify/preintegrated.glsl": "x - half_segment" => "x",
        "classify/preintegrated.glsl": "path / step_size" => "step_size / path";
    m02_the_stack_shows_slices_and_where_they_cut = stack,
        "classify/stack.glsl": "0.05)" => "0.5)";
    p28_a_clear_medium_is_not_seen = |l| classified(l, &[("classify", "clear")]).holds(1e-12, |_| vec![0.0; 4]),
        "classify/clear.glsl": "vec4(0.0)" => "vec4(1.0)";
}

const CLASSIFY: &str =
    "#define ONE_SAMPLE\n#include <clip>\n#include <classify>\nvoid check() { out0 = classify(p0.xyz, p0.w); }";
const IN_PHASES: &str = "#define ONE_SAMPLE\n#include <clip>\n#include <classify>\nvoid check() {
        float density = find_density(p0.xyz);
        out0 = density > 0.0 ? matter_at(p0.xyz, p0.w, density >= 1.0) : vec4(0.0);
    }";

/// A point in or around the soft region of the unit sphere, and the path that it stands for.
fn around(random: &mut Random, _: &Setting) -> [[f64; 4]; 4] {
    let mut p = random.point();
    p[0] = (random.direction() * random.within(0.5, 1.8)).extend(10f64.powf(random.within(-4.0, -1.0))).to_array();
    p
}

pub fn classified(library: &Library, slots: &[(&str, &str)]) -> Check {
    classified_by(library, slots, CLASSIFY)
}

fn classified_by(library: &Library, slots: &[(&str, &str)], text: &str) -> Check {
    Check::new(library, slots, text).given(around)
}

/// D of the unit sphere before any DMF, not held in [0, 1].
pub fn line(at: &At<'_>, x: DVec3) -> f64 {
    let (inner, outer) = (at.number("iso_value"), at.number("outer_iso_value"));
    (outer + 1.0 - x.length()) / (outer - inner)
}

/// PH 3.1.
pub fn opacity(at: &At<'_>, density: f64, path: f64) -> f64 {
    if density >= 1.0 { 1.0 } else { 1.0 - (1.0 - density).powf(at.number("opacity_rate") * path) }
}

pub fn covering(color: DVec3, alpha: f64) -> Vec<f64> {
    (color * alpha).extend(alpha).to_array().to_vec()
}

/// PH 2: H = f1(f0(D)): a bias, then a gain.
fn soft(library: &Library, text: &str) -> f64 {
    let slots = [("dmf", "biased+gained"), ("surface", "tex_coord")];
    classified_by(library, &slots, text).holds(1e-6, |at| {
        let (x, line) = (at.place(0), line(at, at.place(0)).clamp(0.0, 1.0));
        let density = gain(at.number("density_gain"), bias(at.number("density_bias"), line));
        let (low, high) = (at.vector("own_min"), at.vector("own_max"));
        let color = if line >= 1.0 { (x - low) / (high - low) } else { COLOR * at.vector("material_color") };
        covering(color, opacity(at, density, at.p[0][3]))
    })
}

fn surface(library: &Library) -> f64 {
    let slots = [("classify", "surface"), ("softness", "hard")];
    classified(library, &slots).holds(1e-9, |at| {
        let inside = at.place(0).length() - 1.0 <= at.number("iso_value");
        covering(COLOR * at.vector("material_color"), f64::from(inside))
    })
}

fn post(library: &Library) -> f64 {
    classified(library, &[("classify", "post")]).holds(1e-6, |at| {
        let matter = transfer(at, line(at, at.place(0)).clamp(0.0, 1.0));
        covering(DVec3::from_slice(&matter), opacity(at, matter[3], at.p[0][3]))
    })
}

/// The colors of the voxels are weighted with their opacity, and weigh no more when that is taken out again.
fn pre(library: &Library) -> f64 {
    classified(library, &[("classify", "pre")]).holds(1e-6, |at| {
        let p = at.vector("volume_scale") * at.place(0) + at.vector("volume_offset");
        let voxel = filtered(at.texture("classified_image"), &p.to_array(), Wrap::Clamp);
        covering(DVec3::from_slice(&voxel) / voxel[3], opacity(at, voxel[3], at.p[0][3]))
    })
}

/// Engel 2001: a table by the densities at the near and the far end of a step; a path of k steps lets through the k-th
/// power of what one does.
fn preintegrated(library: &Library, slots: &[(&str, &str)]) -> f64 {
    classified(library, slots).holds(1e-6, |at| {
        let (x, path) = (at.place(0), at.p[0][3]);
        let to_eye = DMat3::from_mat4(at.matrix("texture_matrix")) * -at.place(3).normalize();
        let foot = |x: DVec3| x.normalize() * (1.0 + at.number("iso_value"));
        let [near, far] = [0.5, -0.5].map(|half| {
            let x = x + half * path * to_eye;
            narrowed(line(at, x).clamp(0.0, 1.0), painted(at, foot(x)).length)
        });
        let at_texel = |density: f64| (density * 8.0 + 0.5) / 9.0;
        let step = filtered(at.texture("segment_image"), &[at_texel(near), at_texel(far)], Wrap::Clamp);
        let alpha = 1.0 - (1.0 - step[3]).powf(path / at.number("step_size"));
        let groom = painted(at, foot(x - 0.5 * path * to_eye));
        covering(mixed(DVec3::from_slice(&step) / step[3], groom.color), alpha)
    })
}

fn stack(library: &Library) -> f64 {
    classified(library, &[("classify", "stack")]).holds(1e-8, |at| {
        let faint = f64::from(0.05f32);
        match line(at, at.place(0)) > 0.0 {
            true => covering(COLOR * COLOR * at.vector("material_color"), 1.0),
            false => covering(COLOR, faint),
        }
    })
}
