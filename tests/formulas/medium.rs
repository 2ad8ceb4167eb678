//! Appearance of soft matter.

use crate::formulas::density::mix;
use crate::formulas::dual::{Place, moved, place, scaled, value};
use crate::formulas::harness::{At, Check};
use crate::formulas::knots::{noise, turbulence, vector_noise};
use crate::formulas::light::{directions, phong, to_eye_space};
use crate::formulas::surface::{SAMPLE, marble, material, sample, transfer};
use crate::formulas::values::c;
use glam::{DMat3, DVec3};
use hypertexture::shader::Library;

crate::rows! {
    m51_soft_matter_in_the_bare_material = |l| medium(l, "material", material),
        "medium/material.glsl": "color.rgb * material_color.rgb" => "material_color.rgb";
    m51_soft_matter_is_lit_like_the_surface = |l| medium(l, "lit", |at| phong(at, material(at), at.place(2))),
        "medium/lit.glsl": "s.shading" => "s.normal";
    p23_soft_matter_colored_by_the_transfer_map = |l| medium(l, "transfer", |at| DVec3::from_slice(&transfer(at, at.p[1][3]))),
        "medium/transfer.glsl": "transfer(density)" => "transfer(1.0 - density)";
    a_transfer_map_of_one_color_needs_no_density = flat,
        "transfer/flat.glsl": "return transfer_color" => "return density * transfer_color";
    m24_the_soft_region_is_a_tinted_haze = |l| medium(l, "soft_region", |at| {
        DVec3::new(c(0.1), 0.25, 1.0).lerp(DVec3::new(c(0.2), 1.0, c(0.6)), at.p[1][3])
    }),
        "medium/soft_region.glsl": "0.6), density" => "0.6), 1.0 - density";
    g04_colors_are_perturbed_after_the_transfer_map = |l| medium(l, "perturbed", perturbed),
        "medium/perturbed.glsl": "2.0 * p + 29.3" => "2.0 * p - 29.3",
        "medium/perturbed.glsl": "1.0 + irregularity" => "1.0 - irregularity";
    g04_the_fourth_noise_perturbs_the_opacity = |l| extinction(l, "perturbed", |at| {
        let p = perturbed_place(at);
        let fourth = noise(moved(p, 2.0 * DVec3::new(c(13.2), c(5.82), c(7.11)))).v;
        (1.0 + at.number("patchiness") * fourth).max(0.0)
    }),
        "medium/perturbed.glsl": "1.0 + patchiness" => "1.0 - patchiness",
        "four_noises.glsl": "p + 2.0 * NOISE_SHIFT" => "p - 2.0 * NOISE_SHIFT";
    m50_a_flame_may_be_thinner_than_its_density = |l| extinction(l, "flame", |at| at.number("flame_opacity")),
        "medium/flame.glsl": "return flame_opacity" => "return 1.0";
    m45_p29_soft_matter_is_carved_out_of_the_same_block = |l| medium(l, "solid", |at| phong(at, marble(at), at.place(2))),
        "medium/solid.glsl": "s.shading" => "s.normal";
    p30_m53_flames_glow_and_have_relief = |l| medium(l, "flame", flame),
        "medium/flame.glsl": "wide + eye_normal(b)" => "wide - eye_normal(b)",
        "medium/flame.glsl": "0.35 + 1.1 * lit" => "1.1 + 0.35 * lit";
    p58_vapor_is_dark_behind_denser_matter = vapor,
        "medium/vapor.glsl": "(density - blocking) - 0.5" => "(density + blocking) - 0.5",
        "medium/vapor.glsl": "s.x + shade_distance" => "s.x - shade_distance";
}

pub fn medium(library: &Library, module: &str, formula: fn(&At<'_>) -> DVec3) -> f64 {
    let text = format!("{SAMPLE}#include <medium>\nvoid check() {{ out0.xyz = medium(given(), p1.w); }}");
    let check = Check::new(library, &[("medium", module)], &text).given(sample);
    check.holds(2e-8, |at| formula(at).to_array().to_vec())
}

fn flat(library: &Library) -> f64 {
    let text = format!("{SAMPLE}#include <medium>\nvoid check() {{ out0.xyz = medium(given(), p1.w); }}");
    let check = Check::new(library, &[("medium", "transfer"), ("transfer", "flat")], &text).given(sample);
    check.holds(1e-9, |at| at.vector("transfer_color").to_array().to_vec())
}

/// How opaque soft matter is, as a part of the rate.
fn extinction(library: &Library, module: &str, formula: fn(&At<'_>) -> f64) -> f64 {
    let text = format!("{SAMPLE}#include <medium>\nvoid check() {{ out0.x = extinction(given(), p1.w); }}");
    let check = Check::new(library, &[("medium", module)], &text).given(sample);
    check.holds(1e-9, |at| vec![formula(at)])
}

/// Where the noise of the perturbation is asked for.
fn perturbed_place(at: &At<'_>) -> Place {
    let drift = DVec3::NEG_Y * at.number("irregularity_speed") * at.number("time");
    moved(scaled(place(at.place(0)), at.number("irregularity_frequency")), drift)
}

/// GG 39.5: the color times 1 + noise, as a whole and for each channel.
fn perturbed(at: &At<'_>) -> DVec3 {
    let p = perturbed_place(at);
    let whole = at.number("irregularity") * noise(moved(scaled(p, 2.0), DVec3::splat(c(29.3)))).v;
    let each = at.number("iridescence") * value(vector_noise(p));
    DVec3::from_slice(&transfer(at, at.p[1][3])) * (each + 1.0 + whole).max(DVec3::ZERO)
}

/// PH 2.4: the color of the density; MJ 7f: bumpy, by the slope of the rising turbulence.
fn flame(at: &At<'_>) -> DVec3 {
    let risen = DVec3::NEG_Y * at.number("relief_rise") * at.number("time");
    let bump = turbulence(scaled(moved(place(at.place(0)), risen), 2.0)).d;
    // The slope by the place is twice that by the cell, and so is its length.
    let n = (0.75 * to_eye_space(at, at.place(2)) + to_eye_space(at, bump)).normalize();
    let lit = (1.0 + n.dot(directions(at)[0])) / 2.0;
    let color = DVec3::from_slice(&transfer(at, at.p[1][3]));
    at.number("glow") * color * mix(1.0, c(0.35) + c(1.1) * lit, at.number("relief"))
}

/// One sample towards the light: bright where it is thinner there.
fn vapor(library: &Library) -> f64 {
    let text = "#include \"sample.glsl\"\n#include <dmf>\n#include <medium>
        void check() { Sample s; s.x = p0.xyz; out0.xyz = medium(s, p1.w); }";
    let slots = [("medium", "vapor"), ("dmf", "scaled")];
    let check = Check::new(library, &slots, text).given(|random, setting| {
        let mut p = sample(random, setting);
        p[0] = (random.direction() * random.within(0.6, 1.6)).extend(0.0).to_array();
        p
    });
    check.holds(1e-8, |at| {
        let to_light = DMat3::from_mat4(at.matrix("texture_matrix")) * (at.vector("light_position") - at.place(3));
        let there = at.place(0) + at.number("shade_distance") * to_light.normalize();
        let (inner, outer) = (at.number("iso_value"), at.number("outer_iso_value"));
        let density = ((outer + 1.0 - there.length()) / (outer - inner)).clamp(0.0, 1.0);
        let modulated = (at.number("density_factor") * density + at.number("density_offset")).clamp(0.0, 1.0);
        let blocking = if density > 0.0 { modulated } else { 0.0 };
        let light = 0.75 + at.number("shade_depth") * (at.p[1][3] - blocking) / 2.0 - blocking / 2.0;
        let bright = at.vector("vapor_color") * at.vector("light_color");
        at.vector("shade_color").lerp(bright, light.clamp(0.0, 1.0)).to_array().to_vec()
    })
}
