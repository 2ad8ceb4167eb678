//! Where along rays matter may be: bounds of the extinction over parts of them, halved until they say enough.

use super::integral::{self, Extinction, OPEN, Part};
use super::probe::{Probe, extinction};
use super::{BOUNDS, ReferenceError, Stop, go_on};
use hypertexture::eval::{self, Affine, Interval, SegmentBounds};
use std::collections::BTreeMap;

/// Parts of a ray that bounds are computed of first. Fewer: bounds of what is empty say nothing. More: more of them.
const PARTS: u32 = 16;
/// Bounds alone do not look for surfaces in shorter parts than this, in depths of the scene: samples are faster.
const NARROW: f64 = 1.0 / 1024.0;
/// Parts that bounds leave open are not longer than this, in depths of the scene, when they are sampled. Longer: thin
/// matter is overlooked, such as a drip that 512 samples of a device find.
const MAX_OPEN_LENGTH: f64 = 1.0 / 192.0;

/// After this many bounds of halves, halving must pay: of what was open two halvings ago, less than [`PAYS`] of the length
/// still is. Fewer: thin matter far behind the first is given up. More: rays of which nothing can be proven take longer.
const FREE_BOUNDS: usize = 14;
/// More: noise of many octaves is tried in vain. Less: a surface that is nearly tangential is given up.
const PAYS: f64 = 0.85;

/// Where matter may be along a ray, or along the rays of a beam.
#[derive(Clone, Default)]
pub(super) struct Ray {
    pub(super) beam: Beam,
    /// Front to back, each so short that samples see what is in it.
    pub(super) parts: Vec<Part>,
    /// Bounds of halves that were computed.
    spent: usize,
    /// Which parts are halved next.
    halved: Vec<usize>,
    /// Length of the parts that were open before, and before that.
    open: [f64; 2],
    /// More bounds prove nothing.
    pub(super) is_vain: bool,
}

impl Ray {
    /// Halves of the parts that are halved next.
    fn halves(&self) -> impl Iterator<Item = Part> {
        self.halved.iter().flat_map(|&part| {
            let whole = self.parts[part];
            let half = 0.5 * whole.length;
            [whole.from, whole.from + half].map(|from| Part { from, length: half, ..whole })
        })
    }

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
        self.is_vain |= self.spent > FREE_BOUNDS && open > PAYS * self.open[1];
        self.open = [open, self.open[0]];
        let left = if self.is_vain { 0 } else { BOUNDS[0].saturating_sub(self.spent) / 2 };
        self.halved = halved.into_iter().take(left).collect();
        self.spent += 2 * self.halved.len();
    }
}

/// Domain of a bound: a part of a ray, or of all rays through a box of the picture.
#[derive(Clone, Copy, Default)]
pub(super) struct Beam {
    /// From where to where in pixels, by axis.
    across: [[f64; 2]; 2],
    from: f64,
    length: f64,
}

impl Beam {
    /// A part of the ray of a pixel, from a depth and of a length.
    pub(super) fn of([x, y]: [u32; 2], [from, length]: [f64; 2]) -> Beam {
        Beam { across: [x, y].map(|at| [f64::from(at) + 0.5; 2]), from, length }
    }

    /// The same of another ray too.
    fn and(self, pixel: [u32; 2]) -> Beam {
        let across = std::array::from_fn(|axis| {
            let ([low, high], at) = (self.across[axis], f64::from(pixel[axis]) + 0.5);
            [low.min(at), high.max(at)]
        });
        Beam { across, ..self }
    }
}

impl Probe {
    /// Rays with the parts that bounds of the beams around them leave.
    pub(super) fn rays(
        &self,
        bounds: &eval::BoundProgram<'_>,
        pixels: &[[u32; 2]],
        spans: &[[f64; 2]],
        stop: Stop<'_>,
    ) -> Result<Vec<Ray>, ReferenceError> {
        let mut beams: BTreeMap<[u32; 2], (Beam, f64, Vec<usize>)> = BTreeMap::new();
        for (ray, (&pixel, &[from, to])) in
            pixels.iter().zip(spans).enumerate().filter(|(_, (_, [from, to]))| from < to)
        {
            let beam =
                beams.entry(pixel.map(|at| at / self.beam)).or_insert((Beam::of(pixel, [from, 0.0]), to, vec![]));
            (beam.0, beam.1) = (beam.0.and(pixel), beam.1.max(to));
            beam.0.from = beam.0.from.min(from);
            beam.2.push(ray);
        }
        let beams: Vec<(Beam, f64, Vec<usize>)> = beams.into_values().collect();
        let whole = |(beam, to, _): &(Beam, f64, Vec<usize>)| {
            let part = Part { from: beam.from, length: to - beam.from, extinction: Extinction::ANY };
            Ray { beam: *beam, parts: part.pieces(PARTS).collect(), ..Ray::default() }
        };
        let mut shared: Vec<Ray> = beams.iter().map(whole).collect();
        let [near, far] = self.cpu_inputs.depths;
        self.narrow(bounds, &mut shared, self.width * (far - near), stop)?;
        let mut rays: Vec<Ray> =
            pixels.iter().map(|pixel| Ray { beam: Beam::of(*pixel, [0.0; 2]), ..Ray::default() }).collect();
        for ((.., members), shared) in beams.into_iter().zip(shared) {
            for ray in members {
                rays[ray].parts = shared.parts.iter().filter_map(|part| part.within(spans[ray])).collect();
            }
        }
        Ok(rays)
    }

    /// Makes parts of rays narrower, by bounds of their own where that is not vain, until samples see what is in them.
    pub(super) fn split(
        &self,
        bounds: &eval::BoundProgram<'_>,
        rays: &mut [Ray],
        stop: Stop<'_>,
    ) -> Result<(), ReferenceError> {
        let [near, far] = self.cpu_inputs.depths;
        self.narrow(bounds, rays, NARROW * (far - near), stop)?;
        for ray in rays {
            ray.parts = ray.parts.iter().flat_map(|part| part.cut(MAX_OPEN_LENGTH * (far - near))).collect();
        }
        Ok(())
    }

    /// Bounds of all parts of rays, and then of halves that are longer than `shortest`.
    fn narrow(
        &self,
        bounds: &eval::BoundProgram<'_>,
        rays: &mut [Ray],
        shortest: f64,
        stop: Stop<'_>,
    ) -> Result<(), ReferenceError> {
        let mut next: Vec<(usize, Part)> = Vec::new();
        for (index, ray) in rays.iter_mut().enumerate().filter(|(_, ray)| !ray.is_vain) {
            next.extend(std::mem::take(&mut ray.parts).into_iter().map(|part| (index, part)));
        }
        while !next.is_empty() {
            go_on(stop)?;
            let wanted = next.iter().map(|&(ray, Part { from, length, .. })| Beam { from, length, ..rays[ray].beam });
            let found = self.bounds(bounds, &wanted.collect::<Vec<_>>(), OPEN)?;
            let mut found = std::mem::take(&mut next).into_iter().zip(found).peekable();
            for (index, ray) in rays.iter_mut().enumerate() {
                let mut new = std::iter::from_fn(|| found.next_if(|((of, _), _)| *of == index)).peekable();
                if new.peek().is_some() {
                    ray.go_on(new.map(|((_, part), extinction)| Part { extinction, ..part }), shortest);
                    next.extend(ray.halves().map(|half| (index, half)));
                }
            }
        }
        Ok(())
    }

    /// Bounds of the extinction over parts of rays or of beams; a part is split where noise changes its cell if more opacity than
    /// `allowed` is undecided.
    pub(super) fn bounds(
        &self,
        bounds: &eval::BoundProgram<'_>,
        wanted: &[Beam],
        allowed: f64,
    ) -> Result<Vec<Extinction>, ReferenceError> {
        if wanted.is_empty() {
            return Ok(Vec::new());
        }
        // Parts of one depth lie together, and take the same way through the program.
        let mut order: Vec<usize> = (0..wanted.len()).collect();
        order.sort_by(|a, b| wanted[*a].from.total_cmp(&wanted[*b].from));
        let point: fn(f64) -> Affine = eval::Number::new;
        let lanes = order.iter().map(|&at| {
            let Beam { across, from, length } = wanted[at];
            let [x, y] = across.map(|[low, high]| Affine::bounded(Interval::of(low, high)));
            let depth = Affine::between(from, from + length);
            ([x, y, point(0.5), point(1.0)], [depth, point(self.path()), point(0.0), point(0.0)])
        });
        let (fragment_coordinates, places) = lanes.unzip();
        let lanes = eval::Invocations { fragment_coordinates, varyings: [(0, places)].into() };
        let open = |lane: usize, alpha| is_open(self.extinction(alpha), wanted[order[lane]].length, allowed);
        let mut found = vec![Extinction::ANY; wanted.len()];
        for (&at, alpha) in order.iter().zip(bounds.bounds(&lanes, &open)?) {
            found[at] = self.extinction(alpha);
        }
        Ok(found)
    }

    /// Bounds of the extinction by those of an opacity, of which it is a convex function.
    fn extinction(&self, SegmentBounds { all, mean }: SegmentBounds) -> Extinction {
        let of = |alpha: f64| extinction(alpha, self.path());
        let [least, most] = [of(all.lo), of(all.hi)];
        let chord = (mean.hi - all.lo) / (all.hi - all.lo);
        let high = if most.is_finite() && chord.is_finite() { least + chord * (most - least) } else { most };
        Extinction { range: [least, most], mean: [of(mean.lo).max(least), high.min(most)] }
    }
}

/// Whether bounds of the extinction leave more opacity undecided than is allowed, over a part of this length.
fn is_open(extinction: Extinction, length: f64, allowed: f64) -> bool {
    let [most, least] = extinction.transmittance(length);
    most - least > allowed
}
