//! Where along rays matter may be: bounds of the extinction over parts of them, halved until they say enough.

use super::integral::{self, OPEN, Part};
use super::{BOUNDS, Probe, ReferenceError, Stop, extinction, go_on};
use crate::exact::{self, Affine, Interval};

/// Parts of a ray that bounds are computed of first. Fewer: bounds of what is empty say nothing. More: more of them.
const PARTS: usize = 16;
/// Bounds alone do not look for surfaces in shorter parts than this, in depths of the scene: samples are faster.
const NARROW: f64 = 1.0 / 1024.0;
/// Parts that bounds leave open are not longer than this, in depths of the scene, when they are sampled. Longer: thin
/// matter is overlooked, such as a drip that 512 samples of a device find.
const LONGEST: f64 = 1.0 / 192.0;

/// After this many bounds of a ray, halving must pay: of what was open two halvings ago, less than [`PAYS`] of the length
/// still is. Fewer: thin matter far behind the first is given up. More: rays of which nothing can be proven take longer.
const TRIED: usize = 40;
/// More: noise of many octaves is tried in vain. Less: a surface that is nearly tangential is given up.
const PAYS: f64 = 0.85;

/// Where matter may be along a ray.
#[derive(Clone, Default)]
pub(super) struct Ray {
    /// Front to back, each so short that samples see what is in it.
    pub(super) parts: Vec<Part>,
    /// Bounds that were computed.
    spent: usize,
    /// Which parts are halved next.
    halved: Vec<usize>,
    /// Length of the parts that were open before, and before that.
    open: [f64; 2],
    /// Bounds of shorter parts say no more.
    pub(super) is_vain: bool,
}

impl Ray {
    /// Puts halves in place of what was halved, and decides what to halve next.
    fn go_on(&mut self, mut new: impl Iterator<Item = Part>, shortest: f64) {
        if self.halved.is_empty() {
            self.parts.extend(new);
        } else {
            let mut at = std::mem::take(&mut self.halved).into_iter().peekable();
            for (index, part) in std::mem::take(&mut self.parts).into_iter().enumerate() {
                match at.next_if_eq(&index) {
                    Some(_) => self.parts.extend(new.by_ref().take(2)),
                    None => self.parts.push(part),
                }
            }
        }
        let halved = integral::undecided(&mut self.parts, shortest);
        let open = halved.iter().map(|&index| self.parts[index].length).sum();
        self.is_vain |= self.spent > TRIED && open > PAYS * self.open[1];
        self.open = [open, self.open[0]];
        let left = if self.is_vain { 0 } else { BOUNDS[0].saturating_sub(self.spent) / 2 };
        self.halved = halved.into_iter().take(left).collect();
        self.spent += 2 * self.halved.len();
    }
}

impl Probe {
    /// Where along rays matter may be.
    pub(super) fn parts(
        &self,
        bounds: &exact::BoundProgram<'_>,
        pixels: &[[u32; 2]],
        spans: Vec<[f64; 2]>,
        stop: Stop<'_>,
    ) -> Result<Vec<Ray>, ReferenceError> {
        let [near, far] = self.cpu_inputs.depths;
        let [shortest, longest] = [NARROW, LONGEST].map(|part| part * (far - near));
        let mut rays = vec![Ray { spent: PARTS, ..Ray::default() }; pixels.len()];
        let mut wanted: Vec<(usize, [f64; 2])> = Vec::new();
        for (ray, [from, to]) in spans.into_iter().enumerate().filter(|(_, [from, to])| from < to) {
            let length = (to - from) / PARTS as f64;
            wanted.extend((0..PARTS).map(|part| (ray, [from + part as f64 * length, length])));
        }
        while !wanted.is_empty() {
            go_on(stop)?;
            let mut found = (wanted.iter().zip(self.bounds(bounds, pixels, &wanted)?))
                .map(|(&(ray, [from, length]), extinction)| (ray, Part { from, length, extinction }))
                .peekable();
            let mut next = Vec::new();
            for (index, ray) in rays.iter_mut().enumerate() {
                ray.go_on(std::iter::from_fn(|| found.next_if(|(of, _)| *of == index).map(|(_, part)| part)), shortest);
                for part in ray.halved.iter().map(|&part| ray.parts[part]) {
                    let half = 0.5 * part.length;
                    next.extend([(index, [part.from, half]), (index, [part.from + half, half])]);
                }
            }
            wanted = next;
        }
        for ray in &mut rays {
            ray.parts = ray.parts.iter().flat_map(|part| part.cut(longest)).collect();
        }
        Ok(rays)
    }

    /// Bounds of the extinction over parts of rays, each from a depth and of a length.
    pub(super) fn bounds(
        &self,
        bounds: &exact::BoundProgram<'_>,
        pixels: &[[u32; 2]],
        wanted: &[(usize, [f64; 2])],
    ) -> Result<Vec<[f64; 2]>, ReferenceError> {
        if wanted.is_empty() {
            return Ok(Vec::new());
        }
        let path = self.path();
        let places = wanted.iter().map(|&(ray, [from, length])| (ray, Affine::between(from, from + length)));
        let lanes = self.lanes(pixels, places, exact::Number::new);
        let within = |alpha: Interval| [alpha.lo, alpha.hi].map(|alpha| extinction(alpha, path));
        let open = |lane: usize, alpha: Interval| {
            let [least, most] = within(alpha).map(|extinction| extinction * wanted[lane].1[1]);
            (-least).exp() - (-most).exp() > OPEN
        };
        Ok(bounds.bounds(&lanes, open)?.into_iter().map(within).collect())
    }
}
