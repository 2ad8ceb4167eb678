//! Tables of transfer maps applied to densities.

use super::codes::code16;
use super::transfer::evaluate;
use crate::field::DistanceField;
use crate::scene::Transfer;
use glam::Vec4;
use rayon::prelude::*;
use std::cmp::Ordering;

/// Entries along each side of the segment table.
pub(crate) const SEGMENT_SIZE: usize = 256;

/// Transfer map integrated over one segment, for every pair of densities at its front (x) and back (y): premultiplied
/// linear RGBA floats, x fastest. `opacities` maps pairs of a density and a path, as a share of the segment, to
/// opacities.
///
/// The density is linear along the segment, which is cut into four parts for each entry that it crosses. Source: Engel,
/// Kraus and Ertl 2001.
///
/// # Errors
/// Those of `opacities`.
pub(crate) fn segment_table<E: Send>(
    transfer: &Transfer,
    opacities: impl Fn(&[[f32; 2]]) -> Result<Vec<f32>, E> + Sync,
) -> Result<Vec<f32>, E> {
    const PARTS: usize = 4;
    let last = SEGMENT_SIZE - 1;
    let matter = |entry: f32| evaluate(transfer, entry / last as f32);
    let entries: Vec<Vec4> = (0..=last).map(|entry| matter(entry as f32)).collect();
    let middles: Vec<Vec4> = (0..PARTS * last).map(|part| matter((part as f32 + 0.5) / PARTS as f32)).collect();
    // Indexed by the number of crossed entries; without a crossing all parts share one entry.
    let alphas = (0..=last).into_par_iter().map(|crossed| {
        let (matter, part) = (if crossed == 0 { &entries } else { &middles }, 1.0 / (PARTS * crossed.max(1)) as f32);
        opacities(&matter.iter().map(|matter| [matter.w, part]).collect::<Vec<_>>())
    });
    let alphas: Vec<Vec<f32>> = alphas.collect::<Result<_, E>>()?;
    let mut table = vec![0.0; SEGMENT_SIZE * SEGMENT_SIZE * 4];
    table.par_chunks_mut(SEGMENT_SIZE * 4).enumerate().for_each(|(back, row)| {
        for (front, out) in row.chunks_exact_mut(4).enumerate() {
            let alphas = &alphas[front.abs_diff(back)];
            let mut sum = Vec4::ZERO;
            let mut add = |matter: Vec4, alpha: f32| {
                sum += (matter.truncate() * alpha).extend(alpha) * (1.0 - sum.w);
            };
            match front.cmp(&back) {
                Ordering::Equal => (0..PARTS).for_each(|_| add(entries[front], alphas[front])),
                Ordering::Less => (PARTS * front..PARTS * back).for_each(|part| add(middles[part], alphas[part])),
                Ordering::Greater => {
                    (PARTS * back..PARTS * front).rev().for_each(|part| add(middles[part], alphas[part]));
                }
            }
            out.copy_from_slice(&sum.to_array());
        }
    });
    Ok(table)
}

/// Transfer map applied to voxels, for pre-classification: RGBA, 16 bits each, color weighted by density. `densities`
/// maps signed distances in units of the field to densities.
///
/// # Errors
/// Those of `densities`.
pub fn classify<E: Send>(
    field: &DistanceField,
    transfer: &Transfer,
    densities: impl Fn(&[f32]) -> Result<Vec<f32>, E> + Sync,
) -> Result<Vec<u16>, E> {
    const BATCH: usize = 4096;
    let mut texels = vec![0; field.values.len() * 4];
    let parts = texels.par_chunks_mut(4 * BATCH).zip(field.values.par_chunks(BATCH));
    parts.try_for_each(|(out, distances)| {
        for (out, density) in out.chunks_exact_mut(4).zip(densities(distances)?) {
            let matter = evaluate(transfer, density);
            out.copy_from_slice(&(matter.truncate() * matter.w).extend(matter.w).to_array().map(code16));
        }
        Ok(())
    })?;
    Ok(texels)
}

#[cfg(test)]
mod tests {
    use super::super::transfer::tests::ramp;
    use super::*;
    use crate::scene::Curve;

    #[test]
    fn m05_a_segment_of_equal_density_has_its_path_opacity() {
        let opacity = |density: f32, path: f32| 1.0 - (1.0 - 0.9 * density).powf(path);
        let map = ramp(Curve::Linear);
        let opacities =
            |paths: &[[f32; 2]]| Ok::<_, ()>(paths.iter().map(|[density, path]| opacity(*density, *path)).collect());
        let table = segment_table(&map, opacities).unwrap();
        for index in [0, 60, 102, 200, 255] {
            let expected = opacity(evaluate(&map, index as f32 / 255.0).w, 1.0);
            assert!((table[4 * (index * SEGMENT_SIZE + index) + 3] - expected).abs() < 1e-5);
        }
    }
}
