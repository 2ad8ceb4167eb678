//! Pictures and functions in which drivers differ: shader stages, light space, values that cross a loop.

use super::function::Function;
use super::lab::{CaseError, Lab, Rows, number, same};
use hypertexture::scene::{Pass, ShaderStage, preset};

/// Largest difference of a place in light space, object units at a distance of 2: f32 near the pole behind the light.
const MAX_PLACE_ERROR: f64 = 6e-6;
/// Difference from which on a pixel counts, and the share of pixels that may have it: rays at an edge part.
const DIFFERENT: f64 = 1e-2;
const MAX_SHARE: f64 = 3e-3;

/// Slices of segments with a highlight give the picture of rays. Mesa 26.1 reads uniforms behind a loop wrongly.
fn highlights(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let mut scene = preset("dripping_sphere")?;
    (scene.image.size, scene.quality.samples) = ([64, 64], 256);
    let subject = lab.subject(&scene)?;
    let [rays, slices] = [Pass::March, Pass::Slices].map(|pass| {
        scene.quality.pass = pass;
        lab.render(&scene, &subject)
    });
    rows.worst("slices and rays", "segments with a highlight", same(&rays?, &slices?, 4e-3));
    Ok(())
}

/// Bent rays are those of the other shader stage. Of drivers that are known to miss derivatives there is no row: rays are
/// bent by compute shaders there, unless fragment shaders are asked for, which a line says.
fn stages(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let info = lab.gpu.info();
    if !info.computes || info.misses_neighbors() {
        return Ok(());
    }
    let mut scene = preset("blue_glass")?;
    (scene.image.size, scene.quality.samples, scene.quality.supersampling) = ([64, 64], 128, 1);
    let subject = lab.subject(&scene)?;
    let [fragment, compute] = [ShaderStage::Fragment, ShaderStage::Compute].map(|stage| {
        scene.quality.stage = stage;
        lab.render(&scene, &subject)
    });
    let (fragment, compute) = (fragment?, compute?);
    let pixels = fragment.pixels.iter().zip(&compute.pixels);
    let differ = |(a, b): &(&[f32; 4], &[f32; 4])| a.iter().zip(*b).any(|(a, b)| f64::from((a - b).abs()) > DIFFERENT);
    let share = pixels.filter(differ).count() as f64 / fragment.pixels.len() as f64;
    rows.worst("pixels that differ", "bent rays by both stages", [(0.0, share, MAX_SHARE)]);
    Ok(())
}

/// Light space is that of f64, and a place is found again: shadows are looked up where they were cast.
fn light_space(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    const DISTANCE: f64 = 2.0;
    let function = Function::new(lab, include_str!("light_space.glsl"), &[])?;
    for tangent in [0.0, 0.75, -4.0] {
        let found = function.at([1.0, -1.0, tangent, DISTANCE as f32])?;
        let (u, meridian) = (f64::from(tangent), 2.0 * f64::from(tangent).atan());
        let (mut back, mut placed) = (Vec::new(), Vec::new());
        for (number, [x, y, z, there]) in found.into_iter().enumerate() {
            let along = 1.0 - 2.0 * number as f64 / 4096.0;
            let across = (1.0 - along * along).max(0.0).sqrt();
            let turn = [(1.0 - u * u) / (1.0 + u * u), 2.0 * u / (1.0 + u * u)];
            let p = [across * turn[0], across * turn[1], along].map(|c| DISTANCE * c);
            back.extend(p.into_iter().zip([x, y, z]).map(|(known, found)| (known, found, MAX_PLACE_ERROR)));
            let quarter = across.atan2(along) / 4.0;
            placed.push((0.5 + quarter.sin() / 2f64.sqrt() * meridian.cos(), there, MAX_PLACE_ERROR));
        }
        rows.worst("light space and back", format!("meridian {}", number(meridian.to_degrees())), back);
        rows.worst("light space", format!("meridian {}", number(meridian.to_degrees())), placed);
    }
    Ok(())
}

/// All rows.
pub(super) fn rows(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    highlights(lab, rows)?;
    stages(lab, rows)?;
    light_space(lab, rows)
}
