//! Bounding volume hierarchy of the triangles of a mesh: those near a place, in a box, and on a ray.

use super::triangle::{Corners, closest, crossed};
use glam::DVec3;
use rayon::prelude::*;

/// Triangles of a leaf.
const LEAF: usize = 4;
/// Triangles above which halves are built in parallel.
const PARALLEL: usize = 8192;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around {
    pub low: DVec3,
    pub high: DVec3,
}

impl Around {
    /// The box of places.
    pub fn of(places: impl IntoIterator<Item = DVec3>) -> Around {
        let nothing = Around { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
        places.into_iter().fold(nothing, |own, place| Around { low: own.low.min(place), high: own.high.max(place) })
    }

    /// The box with all places up to a distance of it, by axis.
    pub fn grown(self, by: f64) -> Around {
        Around { low: self.low - by, high: self.high + by }
    }

    fn joined(self, other: Around) -> Around {
        Around { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn meets(&self, other: &Around) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    fn distance_squared(&self, place: DVec3) -> f64 {
        place.clamp(self.low, self.high).distance_squared(place)
    }
}

enum Node {
    Leaf(Vec<u32>),
    Halves(Box<[(Around, Node); 2]>),
}

/// Triangles by their numbers, in a tree of boxes.
pub(super) struct Tree {
    corners: Vec<Corners>,
    around: Around,
    root: Node,
}

impl Tree {
    /// Builds the tree.
    pub fn new(corners: Vec<Corners>) -> Tree {
        let mut numbers: Vec<u32> = (0..corners.len() as u32).collect();
        let (around, root) = built(&corners, &mut numbers);
        Tree { corners, around, root }
    }

    /// The corners of a triangle.
    pub fn corners(&self, number: u32) -> &Corners {
        &self.corners[number as usize]
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Calls `found` with each triangle whose box meets another, until it returns false.
    pub fn within(&self, other: &Around, found: &mut impl FnMut(u32) -> bool) -> bool {
        !self.around.meets(other) || self.each(&self.root, &|own| own.meets(other), found)
    }

    /// The distance of a place from the nearest triangle, if below `most`.
    pub fn distance(&self, place: DVec3, most: f64) -> Option<f64> {
        let mut nearest = most * most;
        nearest_of(&self.corners, (&self.around, &self.root), place, &mut nearest);
        (nearest < most * most).then(|| nearest.sqrt())
    }

    /// The first triangle on the way from one place to another, of those that count, and the part of the way to it.
    pub fn first(&self, from: DVec3, to: DVec3, counts: impl Fn(u32) -> bool) -> Option<(f64, u32)> {
        let mut found: Option<(f64, u32)> = None;
        let way = to - from;
        let meets = |own: &Around| {
            let (a, b) = ((own.low - from) / way, (own.high - from) / way);
            let flat = way.cmpeq(DVec3::ZERO);
            let is_beside = flat & (from.cmplt(own.low) | from.cmpgt(own.high));
            let (enters, leaves) =
                (DVec3::select(flat, DVec3::ZERO, a.min(b)), DVec3::select(flat, DVec3::ONE, a.max(b)));
            !is_beside.any() && enters.max_element().max(0.0) <= leaves.min_element().min(1.0) + 1e-12
        };
        self.each(&self.root, &meets, &mut |number| {
            if let Some(part) = crossed(self.corners(number), from, to).filter(|_| counts(number)) {
                found = Some(found.map_or(
                    (part, number),
                    |(least, other)| if part < least { (part, number) } else { (least, other) },
                ));
            }
            true
        });
        found
    }

    fn each(&self, node: &Node, meets: &impl Fn(&Around) -> bool, found: &mut impl FnMut(u32) -> bool) -> bool {
        match node {
            Node::Leaf(numbers) => {
                numbers.iter().all(|number| !meets(&Around::of(self.corners[*number as usize])) || found(*number))
            }
            Node::Halves(halves) => halves.iter().all(|(around, half)| !meets(around) || self.each(half, meets, found)),
        }
    }
}

fn built(corners: &[Corners], numbers: &mut [u32]) -> (Around, Node) {
    if numbers.len() <= LEAF {
        let around = Around::of(numbers.iter().flat_map(|number| corners[*number as usize]));
        return (around, Node::Leaf(numbers.to_vec()));
    }
    let center = |number: &u32| corners[*number as usize].iter().sum::<DVec3>();
    let of = Around::of(numbers.iter().map(center));
    let axis = (of.high - of.low).max_position();
    let middle = numbers.len() / 2;
    numbers.select_nth_unstable_by(middle, |a, b| center(a)[axis].total_cmp(&center(b)[axis]).then(a.cmp(b)));
    let (low, high) = numbers.split_at_mut(middle);
    let halves = if low.len() > PARALLEL {
        rayon::join(|| built(corners, low), || built(corners, high))
    } else {
        (built(corners, low), built(corners, high))
    };
    (halves.0.0.joined(halves.1.0), Node::Halves(Box::new([halves.0, halves.1])))
}

fn nearest_of(corners: &[Corners], (around, node): (&Around, &Node), place: DVec3, nearest: &mut f64) {
    if around.distance_squared(place) >= *nearest {
        return;
    }
    match node {
        Node::Leaf(numbers) => {
            let of = |number: &u32| closest(&corners[*number as usize], place).distance_squared(place);
            *nearest = numbers.iter().map(of).fold(*nearest, f64::min);
        }
        Node::Halves(halves) => {
            let [low, high] = &**halves;
            let is_second = high.0.distance_squared(place) < low.0.distance_squared(place);
            for (around, half) in if is_second { [high, low] } else { [low, high] } {
                nearest_of(corners, (around, half), place, nearest);
            }
        }
    }
}

/// Triangles that pass through another one, or lie folded onto a neighbor.
pub(super) fn self_crossings(tree: &Tree, triangles: &[[u32; 3]]) -> Vec<u32> {
    let is_crossed = |number: &u32| {
        let own = Around::of(*tree.corners(*number));
        !tree.within(&own, &mut |other| other == *number || !meet(tree, triangles, [*number, other]))
    };
    (0..tree.len() as u32).into_par_iter().filter(is_crossed).collect()
}

/// Whether two triangles have more in common than corners and an edge of both.
fn meet(tree: &Tree, triangles: &[[u32; 3]], pair: [u32; 2]) -> bool {
    let [own, other] = pair.map(|number| triangles[number as usize]);
    let shared = own.iter().filter(|corner| other.contains(corner)).count();
    let [a, b] = pair.map(|number| tree.corners(number));
    if shared >= 2 {
        // A fold of two neighbors has opposite normals, and both corners on one side of the edge.
        let [n, m] = [a, b].map(|corners| super::triangle::normal(corners).normalize_or_zero());
        return n.dot(m) < FOLD;
    }
    let crosses = |of: &[u32; 3], corners: &Corners, into: &Corners, not: &[u32; 3]| {
        (0..3).any(|edge| {
            let ends = [edge, (edge + 1) % 3];
            ends.iter().all(|end| !not.contains(&of[*end]))
                && crossed(into, corners[ends[0]], corners[ends[1]]).is_some()
        })
    };
    crosses(&own, a, b, &other) || crosses(&other, b, a, &own)
}

/// Cosine between the normals of neighbors that lie on each other.
const FOLD: f64 = -0.999_999;

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture_support::random::SplitMix;

    fn scattered(count: usize) -> Vec<Corners> {
        let mut random = SplitMix(1977);
        let mut part = move || random.unit();
        (0..count)
            .map(|_| {
                let middle = DVec3::new(part(), part(), part());
                std::array::from_fn(|_| middle + 0.1 * DVec3::new(part(), part(), part()))
            })
            .collect()
    }

    #[test]
    fn a_tree_finds_what_a_search_of_all_finds() {
        let all = scattered(300);
        let tree = Tree::new(all.clone());
        for (index, from) in scattered(40).into_iter().map(|[from, ..]| 1.5 * from - 0.2).enumerate() {
            let nearest = all.iter().map(|corners| closest(corners, from).distance(from)).fold(f64::INFINITY, f64::min);
            assert_eq!(tree.distance(from, nearest * (1.0 + 1e-9) + 1e-12), Some(nearest));
            assert_eq!(tree.distance(from, 0.99 * nearest), None);
            let to = 1.4 * all[index][1] - 0.2;
            let hits = all.iter().filter_map(|corners| crossed(corners, from, to)).fold(f64::INFINITY, f64::min);
            assert_eq!(tree.first(from, to, |_| true).map_or(f64::INFINITY, |(part, _)| part), hits);
        }
    }

    #[test]
    fn crossing_and_folded_triangles_are_found() {
        let crossing = |triangles: &[[u32; 3]], places: &[DVec3]| {
            let corners = triangles.iter().map(|triangle| triangle.map(|corner| places[corner as usize])).collect();
            self_crossings(&Tree::new(corners), triangles)
        };
        let places = [
            DVec3::ZERO,
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            DVec3::new(0.2, 0.2, -1.0),
            DVec3::new(0.2, 0.2, 1.0),
            DVec3::new(0.4, 0.3, 1.0),
            DVec3::new(0.3, 0.3, 0.0),
        ];
        assert_eq!(crossing(&[[0, 1, 2], [4, 5, 6]], &places), [0, 1]);
        assert_eq!(crossing(&[[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], &places), [0_u32; 0], "a tetrahedron");
        assert_eq!(crossing(&[[0, 1, 2], [1, 0, 7]], &places), [0, 1], "a fold");
        assert_eq!(crossing(&[[0, 1, 2], [0, 4, 5]], &places), [0, 1], "with a corner in common");
    }
}
