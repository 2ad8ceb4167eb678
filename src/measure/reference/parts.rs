//! Where along rays matter may be: bounds of the extinction over parts of them, halved until they say enough.

use super::integral::{self, OPEN, Part};
use super::probe::{Probe, extinction};
use super::{BOUNDS, ReferenceError, Stop, go_on};
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

/// One ray of so many is tried first: where bounds of those beside a ray are in vain, its own are not made narrower. More:
/// rays that bounds would prove are given up. Fewer: more bounds.
const BETWEEN: usize = 4;

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
        spans: &[[f64; 2]],
        stop: Stop<'_>,
    ) -> Result<Vec<Ray>, ReferenceError> {
        let [near, far] = self.cpu_inputs.depths;
        let [shortest, longest] = [NARROW, LONGEST].map(|part| part * (far - near));
        let mut rays = vec![Ray { spent: PARTS, ..Ray::default() }; pixels.len()];
        let narrow = |rays: &mut [Ray], which: &[usize]| -> Result<(), ReferenceError> {
            let parts = which.iter().flat_map(|&ray| {
                let [from, to] = spans[ray];
                let length = (to - from) / PARTS as f64;
                let count = if from < to { PARTS } else { 0 };
                (0..count).map(move |part| (ray, [from + part as f64 * length, length]))
            });
            let mut wanted: Vec<(usize, [f64; 2])> = parts.collect();
            while !wanted.is_empty() {
                go_on(stop)?;
                let mut found = (wanted.iter().zip(self.bounds(bounds, pixels, &wanted)?))
                    .map(|(&(ray, [from, length]), extinction)| (ray, Part { from, length, extinction }))
                    .peekable();
                let mut next = Vec::new();
                for &index in which {
                    let ray = &mut rays[index];
                    let new = std::iter::from_fn(|| found.next_if(|(of, _)| *of == index).map(|(_, part)| part));
                    ray.go_on(new, shortest);
                    for part in ray.halved.iter().map(|&part| ray.parts[part]) {
                        let half = 0.5 * part.length;
                        next.extend([(index, [part.from, half]), (index, [part.from + half, half])]);
                    }
                }
                wanted = next;
            }
            Ok(())
        };
        let (tried, others): (Vec<usize>, Vec<usize>) = (0..pixels.len()).partition(|ray| ray % BETWEEN == 0);
        narrow(&mut rays, &tried)?;
        for &ray in &others {
            let before = ray - ray % BETWEEN;
            let near = |tried: &usize| {
                *tried < rays.len()
                    && [0, 1].iter().all(|&axis| pixels[*tried][axis].abs_diff(pixels[ray][axis]) <= BETWEEN as u32)
            };
            let mut beside = [before, before + BETWEEN].into_iter().filter(near).peekable();
            rays[ray].is_vain = beside.peek().is_some() && beside.all(|tried| rays[tried].is_vain);
        }
        narrow(&mut rays, &others)?;
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
        // Parts of one depth lie together, and take the same way through the program.
        let mut order: Vec<usize> = (0..wanted.len()).collect();
        order.sort_by(|a, b| wanted[*a].1[0].total_cmp(&wanted[*b].1[0]));
        let places = order.iter().map(|&at| {
            let (ray, [from, length]) = wanted[at];
            (ray, Affine::between(from, from + length))
        });
        let lanes = self.lanes(pixels, places, exact::Number::new);
        let open = |lane: usize, alpha: Interval| is_open(self.extinctions(alpha), wanted[order[lane]].1[1]);
        let mut found = vec![[0.0; 2]; wanted.len()];
        for (&at, alpha) in order.iter().zip(bounds.bounds(&lanes, open)?) {
            found[at] = self.extinctions(alpha);
        }
        Ok(found)
    }

    /// Bounds of the extinction by those of an opacity.
    fn extinctions(&self, alpha: Interval) -> [f64; 2] {
        [alpha.lo, alpha.hi].map(|alpha| extinction(alpha, self.path()))
    }
}

/// Whether bounds of the extinction say too little about a part of this length.
fn is_open(extinction: [f64; 2], length: f64) -> bool {
    let [most, least] = extinction.map(|extinction| (-extinction * length).exp());
    most - least > OPEN
}
