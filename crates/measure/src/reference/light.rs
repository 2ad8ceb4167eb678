//! Light of a group of rays: bounds of the matter along them, then adaptive samples from front to back, then bounds of what these
//! may have overlooked.

use super::integral::{Limits, OPEN, Part, RayIntegral};
use super::parts::{Beam, Ray};
use super::probe::Probe;
use super::proof::{DECIDED, Proof};
use super::{BOUNDS, ReferenceError, Stop, go_on};
use hypertexture::eval;
use std::collections::HashMap;

/// Most pieces of a ray; the stated error of a ray that needs more is higher.
const MOST_PIECES: usize = 8000;
/// Shortest piece, in depths of the scene: the precision of a surface's depth.
const SHORTEST: f64 = 1e-8;
/// Parts of a ray in the first stage of sampling. Lower: more stages. Higher: more samples behind opaque matter.
const FIRST: usize = 8;

/// Premultiplied RGBA, its estimated error, and the opacity that samples may have overlooked.
pub(super) type Light = ([f64; 4], f64, f64);

/// One ray of so many across, and of so many down, is followed first: what was vain for those beside a ray is not tried again.
/// More: rays that bounds would prove are given up. Fewer: more bounds.
pub(super) const BETWEEN: u32 = 4;
/// Undecided opacity from which on bounds were vain. Lower: rays that bounds would nearly prove are given up. Higher: bounds of noise
/// are computed in vain.
const VAIN: f64 = 0.3;
/// Of pixels that lie apart, those that were followed first and are nearest say what is vain, so many of them.
const NEAREST: usize = 3;

/// Whether bounds proved nothing for the rays around a pixel, of those which were followed first: the corners of its cell of the
/// grid, or the nearest.
fn is_vain_at(pixel: [u32; 2], known: &HashMap<[u32; 2], bool>) -> bool {
    let corners = [[0, 0], [1, 0], [0, 1], [1, 1]].into_iter().filter_map(|corner| {
        let at = |axis: usize| (pixel[axis] / BETWEEN + corner[axis]) * BETWEEN;
        known.get(&[at(0), at(1)]).copied()
    });
    let mut beside: Vec<bool> = corners.collect();
    if beside.is_empty() {
        let mut near: Vec<(u32, bool)> = known
            .iter()
            .map(|(other, is_vain)| ((0..2).map(|axis| other[axis].abs_diff(pixel[axis]).pow(2)).sum(), *is_vain))
            .collect();
        near.sort_unstable();
        beside.extend(near.into_iter().take(NEAREST).map(|(_, is_vain)| is_vain));
    }
    !beside.is_empty() && beside.into_iter().all(|is_vain| is_vain)
}

impl Probe {
    /// Light and error of some pixels.
    pub(super) fn integrate(
        &self,
        programs: (&eval::BoundProgram<'_>, &eval::BoundProgram<'_>),
        pixels: &[[u32; 2]],
        tolerance: f64,
        stop: Stop<'_>,
    ) -> Result<Vec<Light>, ReferenceError> {
        let [near, far] = self.cpu_inputs.depths;
        // Where each ray is inside the box: the depth of that sample does not matter.
        let spans: Vec<(usize, f64)> = (0..pixels.len()).map(|ray| (ray, near)).collect();
        let spans = self.sample(programs.0, pixels, &spans)?.into_iter();
        let spans = spans.map(|sample| [sample.span[0].max(near), sample.span[1].min(far)]);
        let mut rays = self.rays(programs.1, pixels, &spans.collect::<Vec<_>>(), stop)?;

        // Of pixels that lie apart about as many are on that grid.
        let (first, others): (Vec<usize>, Vec<usize>) =
            (0..pixels.len()).partition(|ray| pixels[*ray].iter().all(|at| at % BETWEEN == 0));
        let mut found = vec![([0.0; 4], 0.0, 0.0); pixels.len()];
        let mut vain = HashMap::new();
        for which in [first, others] {
            let mut here: Vec<Ray> = which.iter().map(|&ray| std::mem::take(&mut rays[ray])).collect();
            let pixels: Vec<[u32; 2]> = which.iter().map(|&ray| pixels[ray]).collect();
            here.iter_mut().zip(&pixels).for_each(|(ray, pixel)| ray.is_vain = is_vain_at(*pixel, &vain));
            let lights = self.follow(programs, &pixels, &mut here, tolerance, stop)?;
            for ((&at, pixel), light) in which.iter().zip(pixels).zip(lights) {
                vain.insert(pixel, light.2 > VAIN);
                found[at] = light;
            }
        }
        Ok(found)
    }

    /// Light and error of rays whose possible matter is known.
    fn follow(
        &self,
        (bound, bounds): (&eval::BoundProgram<'_>, &eval::BoundProgram<'_>),
        pixels: &[[u32; 2]],
        parts: &mut [Ray],
        tolerance: f64,
        stop: Stop<'_>,
    ) -> Result<Vec<Light>, ReferenceError> {
        let [near, far] = self.cpu_inputs.depths;
        let limits = Limits { error: tolerance, shortest: (far - near) * SHORTEST, pieces: MOST_PIECES };
        let sample = |wanted: &[(usize, f64)]| self.sample(bound, pixels, wanted);
        self.split(bounds, parts, stop)?;
        let asks = |ray: &Ray| RayIntegral::new(if ray.is_vain { 0 } else { BOUNDS[1] });
        let mut rays: Vec<RayIntegral> = parts.iter().map(asks).collect();

        // Front to back, ever more parts at once, up to where it is dark.
        let mut stage = 0..FIRST;
        while parts.iter().zip(&rays).any(|(ray, seen)| ray.parts.len() > stage.start && !seen.is_dark()) {
            go_on(stop)?;
            let seen = parts.iter().zip(&rays).map(|(ray, seen)| {
                let end = if seen.is_dark() { 0 } else { ray.parts.len().min(stage.end) };
                ray.parts.get(stage.start..end).unwrap_or_default()
            });
            let staged: Vec<&[Part]> = seen.collect();
            let wanted = rays.iter().zip(&staged).enumerate();
            let wanted = wanted.flat_map(|(index, (ray, staged))| ray.first(staged).map(move |depth| (index, depth)));
            let mut samples = sample(&wanted.collect::<Vec<_>>())?.into_iter().map(|sample| sample.matter);
            for (ray, staged) in rays.iter_mut().zip(staged) {
                staged.iter().for_each(|part| ray.push(part, &mut samples));
            }
            stage = stage.end..2 * stage.end;
        }

        loop {
            go_on(stop)?;
            let coarse: Vec<Vec<usize>> = rays.iter_mut().map(|ray| ray.coarse(&limits)).collect();
            let wanted: Vec<(usize, f64)> = (rays.iter().zip(&coarse).enumerate())
                .flat_map(|(index, (ray, coarse))| ray.wanted(coarse).map(move |depth| (index, depth)))
                .collect();
            if wanted.is_empty() {
                break;
            }
            let mut samples = sample(&wanted)?.into_iter().map(|sample| sample.matter);
            let asking: Vec<Beam> = (rays.iter().zip(&coarse).zip(pixels))
                .flat_map(|((ray, coarse), pixel)| ray.asking(coarse).map(|part| Beam::of(*pixel, part)))
                .collect();
            let mut narrower = self.bounds(bounds, &asking, OPEN)?.into_iter();
            for (ray, coarse) in rays.iter_mut().zip(&coarse) {
                ray.halve(coarse, &mut samples, &mut narrower);
            }
        }
        let vain = parts.iter().map(|ray| ray.is_vain);
        let mut proofs: Vec<Proof> = rays.iter().zip(vain).map(|(ray, vain)| Proof::new(ray, &limits, vain)).collect();
        loop {
            go_on(stop)?;
            let wanted = proofs.iter().zip(&rays).zip(pixels);
            let wanted: Vec<Beam> = wanted.flat_map(|((proof, ray), pixel)| proof.wanted(ray, *pixel)).collect();
            if wanted.is_empty() {
                break;
            }
            let mut found = self.bounds(bounds, &wanted, DECIDED)?.into_iter();
            proofs.iter_mut().zip(&rays).for_each(|(proof, ray)| proof.learn(ray, &mut found));
        }
        let light = |(ray, proof): (&RayIntegral, &Proof)| {
            let (light, error) = ray.light(&limits);
            let [r, g, b] = light.color;
            ([r, g, b, 1.0 - light.transmittance], error, proof.open())
        };
        Ok(rays.iter().zip(&proofs).map(light).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_beside_failed_rays_are_given_up() {
        let known = HashMap::from([([4, 4], true), ([8, 4], true), ([100, 4], false), ([4, 40], true)]);
        assert!(is_vain_at([5, 5], &known), "two corners of its cell are known");
        assert!(!is_vain_at([101, 6], &known), "one corner, which was proven");
        assert!(is_vain_at([14, 14], &known), "the three nearest");
        assert!(!is_vain_at([70, 14], &known));
        assert!(!is_vain_at([70, 14], &HashMap::new()), "nothing is known");
    }
}
