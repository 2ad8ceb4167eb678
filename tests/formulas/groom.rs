//! Grooms: a volume of painted channels, and what modules make of them.

use crate::formulas::dual::{Place, dual};
use crate::formulas::harness::{At, Check};
use crate::formulas::light::{lit, phong};
use crate::formulas::surface;
use crate::formulas::values::{c, filtered, image};
use crate::formulas::warp::{displaces, warped};
use glam::DVec3;
use hypertexture::eval::Wrap;
use hypertexture::shader::Library;

crate::rows! {
    a_groom_is_a_volume_over_the_object = channels,
        "groom/volume.glsl": "0.5 / GROOM_REACH" => "0.4",
        "groom/volume.glsl": "own * min(painted, 1.0)" => "own * painted",
        "groom/volume.glsl": "(1.0 - density) / clamp" => "(1.0 - density) * clamp";
    without_a_groom_nothing_is_read = |l| read(l, "none", 1.0),
        "groom/none.glsl": "groomed(code)" => "groomed(code) code";
    without_amounts_nothing_is_read = whole,
        "amount/none.glsl": "amounted(code)" => "amounted(code) code";
    the_root_of_a_place_is_its_foot = |l| read(l, "volume", 0.0),
        "sample.glsl": "s.root = x - (" => "s.root = x + (";
    a_lit_surface_is_painted = |l| colored(l, "lit", |at| phong(at, painted_color(at, surface::material(at)), at.place(1))),
        "surface/lit.glsl": "groom_color(own, s.root)" => "groom_color(own, s.normal)";
    a_solid_texture_is_painted = |l| colored(l, "solid", |at| phong(at, painted_color(at, surface::marble(at)), at.place(1))),
        "surface/solid.glsl": "groom_color(own, s.root)" => "groom_color(own, s.normal)";
    a_bumpy_surface_is_painted = |l| colored(l, "bump", |at| lit(at, painted_color(at, surface::material(at)), surface::bump_normal(at))),
        "surface/bump.glsl": "groom_color(own, s.root)" => "groom_color(own, s.normal)";
    m53_it_melts_as_far_as_is_painted = melting,
        "warp/melting.glsl": "amplitude *= min" => "amplitude += min",
        "warp/melting.glsl": "+= more.x" => "-= more.x",
        "groom/volume.glsl": "/ (2.0 * reach)" => "/ reach";
    a_warp_moves_by_the_painted_amount = |l| dripping(l, "painted"),
        "amounts.glsl": "outerProduct(moved, slope)" => "outerProduct(slope, moved)",
        "amounts.glsl": "before + amount * moved" => "before - amount * moved",
        "amount/painted.glsl": "return groom_amount(x)" => "return 1.0 + groom_amount(x)";
    a_warp_sets_in_above_a_kept_base = |l| dripping(l, "base"),
        "kept_base.glsl": "6.0 * part" => "3.0 * part",
        "kept_base.glsl": "x.y)" => "x.z)",
        "amount/base.glsl": "return above_base(x)" => "return 1.0 + above_base(x)";
    a_warp_is_painted_above_a_kept_base = |l| dripping(l, "both"),
        "amount/both.glsl": "groom_amount(x) * above_base_slope" => "above_base_slope";
}

/// Groom at a place of the skin.
pub struct Painted {
    pub direction: DVec3,
    pub length: f64,
    pub color: DVec3,
    pub density: f64,
}

/// The channels at a place, unpainted for programs that read no groom.
pub fn painted(at: &At<'_>, x: DVec3) -> Painted {
    let place = (x * c(0.5 / 1.125) + 0.5).to_array();
    let of = |name: &str, otherwise: [f64; 4]| {
        at.image(name).map_or(otherwise, |texture| filtered(texture, &place, Wrap::Clamp))
    };
    let (shape, look) = (of("groom_shape_image", [0.0, 0.0, 0.0, 1.0]), of("groom_look_image", [1.0; 4]));
    let [direction, color] = [shape, look].map(|texel| DVec3::from_slice(&texel));
    Painted { direction, length: shape[3], color, density: look[3] }
}

/// From black over its own to full.
pub fn mixed(own: DVec3, painted: DVec3) -> DVec3 {
    own * painted.min(DVec3::ONE) + (1.0 - own).max(DVec3::ZERO) * (painted - 1.0).max(DVec3::ZERO)
}

/// The density where the soft region is this much of its width.
pub fn narrowed(density: f64, length: f64) -> f64 {
    if density >= 1.0 { density } else { (1.0 - (1.0 - density) / length.clamp(c(1e-3), 1.0)).max(0.0) }
}

fn channels(library: &Library) -> f64 {
    let text = "#include \"sample_point.glsl\"
        void check() {
            out0 = vec4(groom_color(p1.xyz, p0.xyz), groom_depth(p2.x, p0.xyz));
            out1 = vec4(groom_direction(p0.xyz), groom_density(p0.xyz));
        }";
    let check = Check::new(library, &[("groom", "volume")], text)
        .with_texture("groom_look_image", image([5; 3], |p| (2.0 * p).extend(p.x).to_array()))
        .given(|random, _| {
            [
                (1.5 * random.in_cube(1.0)).extend(random.unit()).to_array(),
                [random.unit(); 4],
                [random.unit(); 4],
                [0.0; 4],
            ]
        });
    check.holds(1e-6, |at| {
        let own = painted(at, at.place(0));
        let color = mixed(at.place(1), own.color).extend(narrowed(at.p[2][0], own.length));
        [color.to_array(), own.direction.extend(own.density).to_array()].concat()
    })
}

/// A number that a groom changes, and how far the root of a place is from the unit sphere with its inner iso-value.
fn read(library: &Library, module: &str, expected: f64) -> f64 {
    let text = "#include \"sample.glsl\"
        void check() {
            Sample s = sample_object(p0.xyz);
            out0.x = 1.0;
            groomed(out0.x = length(s.root) - 1.0 - iso_value;)
        }";
    let check = Check::new(library, &[("groom", module)], text)
        .given(|random, _| [(random.direction() * random.within(0.5, 1.8)).extend(0.0).to_array(); 4]);
    check.holds(1e-9, move |_| vec![expected])
}

/// A number that amounts change.
fn whole(library: &Library) -> f64 {
    let text = "#include <amount>\nvoid check() { out0.x = p0.x; amounted(out0.x = p0.x + 1.0;) }";
    let check = Check::new(library, &[("amount", "none")], text).given(|random, _| [[random.unit(); 4]; 4]);
    check.holds(0.0, |at| vec![at.p[0][0]])
}

fn painted_color(at: &At<'_>, own: DVec3) -> DVec3 {
    mixed(own, painted(at, at.place(0)).color)
}

fn colored(library: &Library, module: &str, formula: fn(&At<'_>) -> DVec3) -> f64 {
    let text = format!(
        "{}#include <surface>\nvoid check() {{ Sample s = given(); s.root = s.x; out0.xyz = surface(s); }}",
        surface::SAMPLE
    );
    let check = Check::new(library, &[("surface", module), ("groom", "volume")], &text).given(|random, setting| {
        let mut p = surface::sample(random, setting);
        p[0] = random.in_cube(1.2).extend(0.0).to_array();
        p
    });
    check.holds(1e-6, |at| formula(at).to_array().to_vec())
}

/// A painted length that grows evenly along a diagonal, so that differences are its gradient.
fn melting(library: &Library) -> f64 {
    let slope = DVec3::new(0.5, 0.25, 0.125);
    let even = image([16; 3], |p| DVec3::ZERO.extend(p.dot(slope)).to_array());
    let check = warped(library, &[("warp", "melting"), ("groom", "volume")])
        .with_texture("groom_shape_image", even)
        .given(|random, _| {
            let mut p = random.point();
            p[0] = random.in_cube(0.8).extend(0.0).to_array();
            p[1..]
                .iter_mut()
                .for_each(|input| *input = random.in_cube(1.0).extend(random.within(-1.0, 1.0)).to_array());
            p
        });
    displaces(check, 1e-6, |at, x: Place| {
        let slope = [0.5, 0.25, 0.125].map(|slope| slope * c(0.5 / 1.125));
        let length = (0..3).fold(dual(0.875 / 2.0), |sum, axis| sum + x[axis] * slope[axis]);
        let [_, bare, _] = crate::formulas::warp::melting(at, x);
        [x[0], x[1] + (bare - x[1]) * length, x[2]]
    })
}

/// An amount that grows evenly along a diagonal, and sets in between two heights.
fn dripping(library: &Library, module: &'static str) -> f64 {
    let slope = DVec3::new(0.5, 0.25, 0.125);
    let even = image([16; 3], |p| DVec3::splat(2.0 * p.dot(slope)).extend(0.0).to_array());
    let check = warped(library, &[("warp", "dripping"), ("groom", "volume"), ("amount", module)])
        .with_texture("groom_amount_image", even)
        .given(|random, _| {
            let mut p = random.point();
            p[0] = random.in_cube(0.8).extend(0.0).to_array();
            let slope = |input: &mut [f64; 4]| *input = random.in_cube(1.0).extend(random.within(-1.0, 1.0)).to_array();
            p[1..].iter_mut().for_each(slope);
            p
        });
    displaces(check, 1e-6, move |at, x: Place| {
        let [low, high] = ["own_min", "own_max"].map(|name| at.fourth(name));
        let part = ((x[1] - dual(low)) / dual(high - low)).clamp(0.0, 1.0);
        let above = part * part * (dual(3.0) - part * 2.0);
        let slope = [0.5, 0.25, 0.125].map(|slope| 2.0 * slope * c(0.5 / 1.125));
        let painted = (0..3).fold(dual(0.875), |sum, axis| sum + x[axis] * slope[axis]);
        let amount = match module {
            "painted" => painted,
            "base" => above,
            _ => above * painted,
        };
        let [_, whole, _] = crate::formulas::warp::dripping(at, x);
        [x[0], x[1] + (whole - x[1]) * amount, x[2]]
    })
}
