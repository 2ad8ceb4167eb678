//! Where along rays matter may be: bounds of the extinction over parts of them, halved until they say enough.

use super::integral::{self, OPEN, Part};
use super::probe::{Probe, extinction};
use super::{BOUNDS, ReferenceError, Stop, go_on};
use crate::exact::{self, Affine, Interval};
use std::collections::{BTreeMap, HashMap};

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

/// One ray of so many across, and of so many down, is tried first: where bounds of those beside a ray are in vain, its own
/// are not made narrower. More: rays that bounds would prove are given up. Fewer: more bounds.
const BETWEEN: u32 = 4;

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
        self.is_vain |= self.spent > TRIED && open > PAYS * self.open[1];
        self.open = [open, self.open[0]];
        let left = if self.is_vain { 0 } else { BOUNDS[0].saturating_sub(self.spent) / 2 };
        self.halved = halved.into_iter().take(left).collect();
        self.spent += 2 * self.halved.len();
    }
}

/// What bounds are computed of: a part of a ray, or of all rays through a box of the picture.
#[derive(Clone, Copy)]
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
        let mut rays = self.beams(bounds, pixels, spans)?;
        let narrow = |rays: &mut [Ray], which: &[usize]| -> Result<(), ReferenceError> {
            // Its own bounds of what those of its beam leave, and then of halves.
            let mut next: Vec<(usize, Part)> = Vec::new();
            for &ray in which {
                next.extend(std::mem::take(&mut rays[ray].parts).into_iter().map(|part| (ray, part)));
            }
            while !next.is_empty() {
                go_on(stop)?;
                let beams = next.iter().map(|(ray, part)| Beam::of(pixels[*ray], [part.from, part.length]));
                let found = self.bounds(bounds, &beams.collect::<Vec<_>>())?;
                let mut found = std::mem::take(&mut next).into_iter().zip(found).peekable();
                for &index in which {
                    let new = std::iter::from_fn(|| found.next_if(|((of, _), _)| *of == index));
                    let ray = &mut rays[index];
                    ray.go_on(new.map(|((_, part), extinction)| Part { extinction, ..part }), shortest);
                    next.extend(ray.halves().map(|half| (index, half)));
                }
            }
            Ok(())
        };
        let (tried, others): (Vec<usize>, Vec<usize>) =
            (0..pixels.len()).partition(|ray| pixels[*ray].iter().all(|at| at % BETWEEN == 0));
        narrow(&mut rays, &tried)?;
        let tried: HashMap<[u32; 2], bool> = tried.iter().map(|&ray| (pixels[ray], rays[ray].is_vain)).collect();
        let others: Vec<usize> = others
            .into_iter()
            .filter(|&ray| {
                let corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|corner| {
                    let at: [u32; 2] =
                        std::array::from_fn(|axis| (pixels[ray][axis] / BETWEEN + corner[axis]) * BETWEEN);
                    tried.get(&at)
                });
                let mut beside = corners.into_iter().flatten().peekable();
                rays[ray].is_vain = beside.peek().is_some() && beside.all(|is_vain| *is_vain);
                !rays[ray].is_vain
            })
            .collect();
        narrow(&mut rays, &others)?;
        for ray in &mut rays {
            ray.parts = ray.parts.iter().flat_map(|part| part.cut(longest)).collect();
        }
        Ok(rays)
    }

    /// Rays with the parts that bounds of the beams around them leave.
    fn beams(
        &self,
        bounds: &exact::BoundProgram<'_>,
        pixels: &[[u32; 2]],
        spans: &[[f64; 2]],
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
        let cut = beams.values().flat_map(|(beam, to, _)| {
            let length = (to - beam.from) / PARTS as f64;
            (0..PARTS).map(move |part| Beam { from: beam.from + part as f64 * length, length, ..*beam })
        });
        let wanted: Vec<Beam> = cut.collect();
        let found = self.bounds(bounds, &wanted)?;
        let mut rays = vec![Ray { spent: PARTS, ..Ray::default() }; pixels.len()];
        let parts = wanted.chunks(PARTS).zip(found.chunks(PARTS));
        for ((.., members), (parts, found)) in beams.values().zip(parts) {
            for &ray in members {
                let [enters, leaves] = spans[ray];
                let parts = parts.iter().zip(found).filter(|(_, extinction)| extinction[1] > 0.0);
                rays[ray].parts.extend(parts.filter_map(|(part, &extinction)| {
                    let (from, to) = (part.from.max(enters), (part.from + part.length).min(leaves));
                    (from < to).then_some(Part { from, length: to - from, extinction })
                }));
            }
        }
        Ok(rays)
    }

    /// Bounds of the extinction over parts of rays or of beams.
    pub(super) fn bounds(
        &self,
        bounds: &exact::BoundProgram<'_>,
        wanted: &[Beam],
    ) -> Result<Vec<[f64; 2]>, ReferenceError> {
        if wanted.is_empty() {
            return Ok(Vec::new());
        }
        // Parts of one depth lie together, and take the same way through the program.
        let mut order: Vec<usize> = (0..wanted.len()).collect();
        order.sort_by(|a, b| wanted[*a].from.total_cmp(&wanted[*b].from));
        let point: fn(f64) -> Affine = exact::Number::new;
        let lanes = order.iter().map(|&at| {
            let Beam { across, from, length } = wanted[at];
            let [x, y] = across.map(|[low, high]| Affine::bounded(Interval::of(low, high)));
            let depth = Affine::between(from, from + length);
            ([x, y, point(0.5), point(1.0)], [depth, point(self.path()), point(0.0), point(0.0)])
        });
        let (fragment_coordinates, places) = lanes.unzip();
        let lanes = exact::Lanes { fragment_coordinates, varyings: [(0, places)].into() };
        let open = |lane: usize, alpha: Interval| is_open(self.extinctions(alpha), wanted[order[lane]].length);
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
