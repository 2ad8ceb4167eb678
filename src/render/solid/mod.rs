//! Solids: the surface of a density as a mesh with few triangles and a proven distance.
//!
//! Role: [`solid`] samples the density where bounds leave open whether there is a surface, marches the cells, decimates the
//! triangles and proves how far they are from the surface. Invariant: each number of a [`Proof`] is proven by evaluations of
//! the scene's program in f64 and in bounds; what is not proven is counted.

mod cover;
mod decimate;
mod error;
mod facts;
mod lost;
mod quadric;
mod refine;
mod tree;
mod triangle;

pub use error::SolidError;
pub use facts::SolidFacts;

use crate::field::{LevelSet, Progress};
use crate::render::density::{Density, DensityProgram, Lattice, PolygonizeError, Signs, colors, crossings, world};
use crate::render::subject::Subject;
use crate::render::variant::{Checkable, Variant};
use crate::shader::Library;
use crate::shape::{Looks, Mesh};
use decimate::{LAST, Limits, decimate};
use foldhash::{HashSet, HashSetExt};
use glam::{DVec3, Vec3};
use hypertexture_support::memory;
use rayon::prelude::*;
use refine::{Vertex, split};
use tree::{Around, Tree};
use triangle::{Corners, normal};

/// Distance between samples, in tolerances. Lower: time and memory grow as the square. Higher: thicker matter is lost.
const STEP: f64 = 2.0;
/// Distance that decimation may use, in tolerances: the rest is for the cells, and for what a mean square hides.
const DECIMATED: f64 = 0.5;
/// Attempts at a decimation; each keeps more of the triangles where the one before failed. After these, only crossings and
/// lost matter count.
const ATTEMPTS: u32 = LAST as u32 + 1;
const MOST_ATTEMPTS: u32 = 8;
/// Splits of the longest edges of what is still open.
const SPLITS: u32 = 4;
/// Accuracy of vertices, in steps.
const EXACT: f64 = 2.2e-4;
/// Factor between the distances that are tried for what the tolerance leaves open, and their number.
const LADDER: f64 = std::f64::consts::SQRT_2;
const RUNGS: i32 = 8;
/// Least tolerance, in the longest side: 32-bit coordinates are 200 times as fine.
const LEAST: f64 = 1.0 / (1 << 16) as f64;
/// Part of the memory of this machine that a mesh may use.
const MEMORY: f64 = 0.6;
/// Fewest samples along the longest side for a number of triangles, and the full triangles for each of them.
const SAMPLES: f64 = 96.0;
const FULL: usize = 6;

/// Detail of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Detail {
    /// Largest distance of the mesh from the surface, world units of the object.
    Tolerance(f64),
    /// Most triangles; the distance is what they give.
    Triangles(usize),
}

/// Distances of a solid, world units, and what is left open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proof {
    /// Distance to the surface within which [`Proof::share`] of the area is proven to be.
    pub distance: f64,
    /// Part of the area, 0 to 1.
    pub share: f64,
    /// Distance within which all of it is proven to be; `None` if there is none up to 16 times [`Proof::distance`].
    pub largest: Option<f64>,
    /// Diameter of a ball above which no ball of matter, and none of a gap, is without the mesh.
    pub lost: f64,
    /// Samples that break [`Proof::lost`].
    pub lost_samples: usize,
    /// Triangles that pass through others.
    pub crossings: usize,
}

/// A mesh for printers.
#[derive(Clone, Debug)]
pub struct Solid {
    /// The mesh: closed, wound outward, manifold, in the world units and axes of its main object.
    pub mesh: Mesh,
    /// Normals of the mesh and colors of the matter at its vertices.
    pub looks: Looks,
    /// Proven distances and what is left open.
    pub proof: Proof,
    /// Triangles before decimation.
    pub full: usize,
}

/// The full mesh and the density that it is of, in object space.
struct Full<'a> {
    density: Density<'a>,
    lattice: Lattice,
    signs: Signs,
    /// Vertices, on the surface.
    places: Vec<DVec3>,
    /// The nearest places known to be inside.
    inside: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

/// A decimated mesh with its defects.
#[derive(Clone)]
struct Attempt {
    vertices: Vec<Vertex>,
    triangles: Vec<[u32; 3]>,
    corners: Vec<Corners>,
    is_proven: Vec<bool>,
    lost: Vec<DVec3>,
    crossed: Vec<u32>,
}

/// Mesh of a scene at its first moment for printers and other programs. Memory and time grow as the surface over the square
/// of the tolerance. `progress` receives the finished share, from any thread.
///
/// # Errors
/// Those of [`polygonize`](crate::render::polygonize), and a tolerance that is out of range or needs too much memory.
pub fn solid(
    library: &Library,
    scene: &impl Checkable,
    subject: &Subject,
    (density, detail): (f32, Detail),
    progress: Progress<'_>,
) -> Result<Solid, SolidError> {
    let variant = scene.checked(library).map_err(PolygonizeError::from)?;
    if !(density > 0.0 && density <= 1.0) {
        return Err(PolygonizeError::Density(density).into());
    }
    let program = DensityProgram::of(library, &variant, subject)?;
    let unit = world_unit(&variant, subject);
    let (low, high) = (program.view.box_min.as_dvec3(), program.view.box_max.as_dvec3());
    let longest = (high - low).max_element();
    let mut step = match detail {
        Detail::Tolerance(tolerance) => {
            let finest = ((high - low).element_product() / f64::from(u32::MAX)).cbrt() * 1.01 / STEP;
            let [least, most] = [(LEAST * longest).max(finest), longest / 16.0].map(|limit| limit * unit);
            if !(least..=most).contains(&tolerance) {
                return Err(SolidError::Tolerance { tolerance, least, most });
            }
            STEP * tolerance / unit
        }
        Detail::Triangles(count) if (100..=10_000_000).contains(&count) => longest / SAMPLES,
        Detail::Triangles(count) => return Err(SolidError::Triangles(count)),
    };
    let full = loop {
        let full =
            Full::of(&program, density, (low, high, step), &|done| progress(0.4 * done)).map_err(|error| {
                match (error, detail) {
                    (
                        SolidError::Polygonize(PolygonizeError::Memory { needed, most }),
                        Detail::Tolerance(tolerance),
                    ) => {
                        let fits = 1.1 * tolerance * (needed as f64 / most as f64).sqrt();
                        SolidError::Memory { tolerance, needed, most, fits }
                    }
                    (error, _) => error,
                }
            })?;
        match detail {
            Detail::Triangles(count) if full.triangles.len() < FULL * count => {
                step *= (full.triangles.len() as f64 / (1.2 * (FULL * count) as f64)).sqrt();
            }
            _ => break full,
        }
    };
    let (distance, limits) = match detail {
        Detail::Tolerance(tolerance) => {
            (Some(tolerance / unit), Limits { distance: DECIMATED * tolerance / unit, least: 0 })
        }
        Detail::Triangles(least) => (None, Limits { distance: longest / 16.0, least }),
    };
    let written = |place: DVec3| world(subject, &variant.scene.object, place).as_vec3();
    let attempt = full.decimated(&written, (distance, limits), &|done| progress(0.4 + 0.4 * done))?;
    let proof = full.proof(&attempt, distance, &|done| progress(0.8 + 0.2 * done))?;
    let proof = Proof {
        distance: proof.distance * unit,
        largest: proof.largest.map(|largest| largest * unit),
        lost: proof.lost * unit,
        ..proof
    };
    let (used, triangles) = compact(&attempt.triangles, attempt.vertices.len());
    let vertices: Vec<Vertex> = used.iter().map(|vertex| attempt.vertices[*vertex as usize]).collect();
    let positions = vertices.iter().map(|[place, _]| written(*place)).collect();
    let mesh = Mesh { positions, triangles, offset: subject.offset, ..Mesh::default() };
    let inside: Vec<DVec3> = vertices.into_iter().map(|[_, inside]| inside).collect();
    let looks = Looks { normals: mesh.vertex_normals(), colors: colors(library, &variant, subject, &inside)? };
    Ok(Solid { mesh, looks, proof, full: full.triangles.len() })
}

/// World units in one of object space, at most: stretched objects have several.
fn world_unit(variant: &Variant, subject: &Subject) -> f64 {
    f64::from(Vec3::from(variant.scene.object.stretch).abs().max_element()) / f64::from(subject.scale)
}

impl Attempt {
    /// Triangles that are not proven.
    fn open(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.triangles.len()).filter(|number| !self.is_proven[*number])
    }
}

impl Full<'_> {
    fn of<'a>(
        program: &'a DensityProgram,
        density: f32,
        (low, high, step): (DVec3, DVec3, f64),
        progress: Progress<'_>,
    ) -> Result<Full<'a>, SolidError> {
        let density = program.bound(f64::from(density))?;
        let most = memory::available().map_or(u64::MAX, |bytes| (MEMORY * bytes as f64) as u64);
        let needed = u64::MAX;
        let lattice = Lattice::anchored(low, high, step).ok_or(PolygonizeError::Memory { needed, most })?;
        let signs = Signs::of(&density, &lattice, most, &|done| progress(0.6 * done))?;
        let set = LevelSet::of(lattice.size, &signs.blocks);
        let found = crossings(&density, &lattice, &set.edges, &|done| progress(0.6 + 0.4 * done))?;
        let (places, inside) = found.into_iter().map(|[place, inside]| (place, inside)).unzip();
        Ok(Full { density, lattice, signs, places, inside, triangles: set.triangles })
    }

    /// Decimates to a distance, and again with more vertices where that failed; what is left open then is split. A number of
    /// triangles has one attempt. `written` gives the
    /// coordinates of the file.
    fn decimated(
        &self,
        written: &(dyn Fn(DVec3) -> Vec3 + Sync),
        (distance, limits): (Option<f64>, Limits),
        progress: Progress<'_>,
    ) -> Result<Attempt, SolidError> {
        let step = self.lattice.step;
        let mut levels = vec![0; self.places.len()];
        let mut known = HashSet::new();
        let mut number = 0;
        let mut attempt = loop {
            number += 1;
            let mut triangles = self.triangles.clone();
            decimate(&self.places, &mut triangles, &levels, &limits);
            progress((number as f32 - 0.5) / MOST_ATTEMPTS as f32);
            let vertices = self.places.iter().zip(&self.inside).map(|(place, inside)| [*place, *inside]).collect();
            let attempt = self.examined((vertices, triangles), written, distance, &mut known)?;
            let is_new = |triangle: &[u32; 3]| triangle.iter().any(|corner| levels[*corner as usize] < LAST);
            let crossed = attempt.crossed.iter().map(|number| *number as usize);
            let open = attempt.open().filter(|_| number < ATTEMPTS);
            let failed = open.chain(crossed).filter(|number| is_new(&attempt.triangles[*number]));
            let boxes = failed.map(|number| Around::of(attempt.corners[number]).grown(step));
            let boxes: Vec<Around> =
                boxes.chain(attempt.lost.iter().map(|place| Around::of([*place]).grown(3.0 * step))).collect();
            progress(number as f32 / MOST_ATTEMPTS as f32);
            if boxes.is_empty() || number == MOST_ATTEMPTS || distance.is_none() {
                break attempt;
            }
            let failed = Tree::new(boxes.iter().map(|own| [own.low, own.high, 0.5 * (own.low + own.high)]).collect());
            levels.par_iter_mut().zip(&self.places).for_each(|(level, place)| {
                if !failed.within(&Around::of([*place]), &mut |_| false) {
                    *level = if number < ATTEMPTS { LAST.min(*level + 1) } else { LAST };
                }
            });
        };
        for _ in 0..if distance.is_some() { SPLITS } else { 0 } {
            let open: Vec<usize> = attempt.open().collect();
            let (mut vertices, mut triangles) = (attempt.vertices.clone(), attempt.triangles.clone());
            let tolerance = distance.unwrap_or(step);
            if open.is_empty() || split(&self.density, tolerance, &mut vertices, &mut triangles, &open)?.is_empty() {
                break;
            }
            let next = self.examined((vertices, triangles), written, distance, &mut known)?;
            if next.crossed.len() > attempt.crossed.len() || next.lost.len() > attempt.lost.len() {
                break;
            }
            attempt = next;
        }
        Ok(attempt)
    }

    /// The defects of a mesh.
    fn examined(
        &self,
        (vertices, triangles): (Vec<Vertex>, Vec<[u32; 3]>),
        written: &(dyn Fn(DVec3) -> Vec3 + Sync),
        distance: Option<f64>,
        known: &mut HashSet<[u32; 3]>,
    ) -> Result<Attempt, SolidError> {
        let of = |triangle: &[u32; 3]| triangle.map(|corner| vertices[corner as usize][0]);
        let corners: Vec<Corners> = triangles.iter().map(of).collect();
        let is_proven = match distance {
            Some(distance) => self.proven(&triangles, &corners, distance, known)?,
            None => vec![true; triangles.len()],
        };
        let crossed = corners.par_iter().map(|corners| corners.map(|corner| written(corner).as_dvec3())).collect();
        let crossed = tree::self_crossings(&Tree::new(crossed), &triangles);
        let tree = Tree::new(corners.clone());
        let lost = lost::lost_samples(&tree, &self.signs, &self.lattice, distance.unwrap_or(self.lattice.step));
        Ok(Attempt { vertices, triangles, corners, is_proven, lost, crossed })
    }

    /// Which triangles stay within a distance of the surface; `known` ones do.
    fn proven(
        &self,
        triangles: &[[u32; 3]],
        corners: &[Corners],
        distance: f64,
        known: &mut HashSet<[u32; 3]>,
    ) -> Result<Vec<bool>, SolidError> {
        let asked: Vec<usize> = (0..triangles.len()).filter(|number| !known.contains(&triangles[*number])).collect();
        let of: Vec<Corners> = asked.iter().map(|number| corners[*number]).collect();
        let found = cover::proven(&self.density, &of, (distance, EXACT * self.lattice.step), &|_| ())?;
        let mut is_proven = vec![true; triangles.len()];
        for (number, found) in asked.into_iter().zip(found) {
            is_proven[number] = found;
            if found {
                known.insert(triangles[number]);
            }
        }
        Ok(is_proven)
    }

    /// The distances that are proven, object units: at `distance`, or where most of the area is.
    fn proof(&self, attempt: &Attempt, asked: Option<f64>, progress: Progress<'_>) -> Result<Proof, SolidError> {
        let area = |number: usize| normal(&attempt.corners[number]).length();
        let all: f64 = (0..attempt.corners.len()).map(area).sum();
        let mut open: Vec<usize> = match asked {
            Some(_) => attempt.open().collect(),
            None => (0..attempt.corners.len()).collect(),
        };
        let share = |open: &[usize]| 1.0 - open.iter().map(|number| area(*number)).sum::<f64>() / all;
        let first = asked.unwrap_or(self.lattice.step / 16.0);
        let (mut reached, mut largest) = (asked.map(|distance| (distance, share(&open))), None);
        let rungs = if asked.is_some() { RUNGS } else { 2 * RUNGS };
        for rung in 1..=rungs {
            if open.is_empty() {
                break;
            }
            let next = first * LADDER.powi(rung);
            let of: Vec<Corners> = open.iter().map(|number| attempt.corners[*number]).collect();
            let found = cover::proven(&self.density, &of, (next, EXACT * self.lattice.step), &|_| ())?;
            open = open.into_iter().zip(found).filter(|(_, found)| !found).map(|(number, _)| number).collect();
            largest = open.is_empty().then_some(next);
            if reached.is_none() && share(&open) >= MOST {
                reached = Some((next, share(&open)));
            }
            progress(rung as f32 / rungs as f32);
        }
        let (distance, share) = reached.unwrap_or((first * LADDER.powi(rungs), share(&open)));
        let lost = 3.0_f64.sqrt() * self.lattice.step + 2.0 * distance;
        let lost_samples = match asked {
            Some(_) => attempt.lost.len(),
            None => {
                let tree = Tree::new(attempt.corners.clone());
                lost::lost_samples(&tree, &self.signs, &self.lattice, distance).len()
            }
        };
        let is_whole = open.is_empty();
        Ok(Proof {
            distance,
            share,
            largest: if is_whole { largest.or(Some(distance)) } else { None },
            lost,
            lost_samples,
            crossings: attempt.crossed.len(),
        })
    }
}

/// Part of the area whose distance is that of a mesh with a number of triangles.
const MOST: f64 = 0.99;

/// The vertices that triangles use, and the triangles by their places among those.
fn compact(triangles: &[[u32; 3]], vertices: usize) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut is_used = vec![false; vertices];
    triangles.as_flattened().iter().for_each(|corner| is_used[*corner as usize] = true);
    let used: Vec<u32> = (0..vertices as u32).filter(|vertex| is_used[*vertex as usize]).collect();
    let mut numbers = vec![0; vertices];
    used.iter().enumerate().for_each(|(number, vertex)| numbers[*vertex as usize] = number as u32);
    (used, triangles.iter().map(|triangle| triangle.map(|corner| numbers[corner as usize])).collect())
}
