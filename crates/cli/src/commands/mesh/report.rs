//! Facts about a written mesh, as lines and as JSON.

use glam::Vec3;
use hypertexture::render::{Millimeters, Proof, SolidFacts};
use hypertexture::shape::{self, Body, Edges, MeshFormat};
use hypertexture_support::significant;
use serde_json::{Value, json};

/// Part of the largest body below which a body is called a speck.
const SPECK: f64 = 1e-3;

/// Facts about a mesh, in world units.
pub(super) struct Report {
    pub edges: Edges,
    pub triangles: usize,
    pub size: Vec3,
    pub volume: f64,
    /// Bodies by falling volume, and how many of the last were dropped.
    pub bodies: Vec<Body>,
    pub dropped: usize,
    pub millimeters: Option<Millimeters>,
    pub solid: Option<SolidReport>,
}

/// Facts about a mesh that is held to a tolerance or a number of triangles.
pub(super) struct SolidReport {
    pub proof: Proof,
    /// Triangles before decimation.
    pub full: usize,
    pub facts: SolidFacts,
}

impl Report {
    pub fn of(mesh: &shape::Mesh, bodies: Vec<Body>, dropped: usize) -> Report {
        let bounds = mesh.bounds();
        Report {
            edges: mesh.edges(),
            triangles: mesh.triangles.len(),
            size: bounds.max - bounds.min,
            volume: mesh.signed_volume(),
            bodies,
            dropped,
            millimeters: None,
            solid: None,
        }
    }

    /// Millimeters, or world units of an object without a unit.
    fn per_unit(&self) -> f64 {
        self.millimeters.map_or(1.0, |size| size.per_world_unit)
    }

    /// A length in world units with its unit.
    fn length(&self, length: f64) -> String {
        let unit = if self.millimeters.is_some() { "mm" } else { "units" };
        format!("{} {unit}", significant(length * self.per_unit(), 3))
    }

    /// The proof in words; `None` for a mesh of a grid.
    pub fn statement(&self) -> Option<String> {
        let SolidReport { proof, .. } = self.solid.as_ref()?;
        let share = if proof.share >= 1.0 { "all".into() } else { percent(proof.share) + " of" };
        let rest = match proof.largest {
            _ if proof.share >= 1.0 => String::new(),
            Some(largest) => format!(", within {} of all of it", self.length(largest)),
            None => format!(", and the other {} not proven", percent(1.0 - proof.share)),
        };
        let lost = match proof.lost_samples {
            0 => format!("no matter and no gap thicker than {} is lost", self.length(proof.lost)),
            count => {
                format!("{count} places of matter or gaps are lost, each thicker than {}", self.length(proof.distance))
            }
        };
        let crossings = match proof.crossings {
            0 => String::new(),
            count => format!("; {count} triangles pass through others"),
        };
        Some(format!("within {} of {share} the area (proven){rest}; {lost}{crossings}", self.length(proof.distance)))
    }

    /// Lines for people.
    pub fn lines(&self, format: MeshFormat) -> String {
        let Report { edges, size, .. } = self;
        let is_whole = edges.open + edges.crowded + edges.turned == 0;
        let mut lines = vec![format!(
            "mesh       {} vertices, {} triangles{}, {}; {}",
            edges.vertices,
            self.triangles,
            self.solid.as_ref().map_or(String::new(), |solid| format!(" of {}", solid.full)),
            if edges.bodies == 1 { "1 body".into() } else { format!("{} bodies", edges.bodies) },
            if is_whole { "watertight" } else { "not watertight" },
        )];
        lines.extend(self.statement().map(|statement| format!("surface    {statement}")));
        let [x, y, z] = size.to_array().map(|side| significant(f64::from(side), 6));
        let volume = significant(self.volume, 6);
        lines.push(format!("size       {x} x {y} x {z}, volume {volume} cubic world units"));
        lines.extend(self.specks().map(|specks| format!("bodies     {specks}")));
        lines.extend(self.print(format).map(|print| format!("print      {print}")));
        if let Some(SolidReport { facts, .. }) = &self.solid {
            lines.extend(facts.thinnest.map(|(wall, place)| {
                let [x, y, z] = place.to_array().map(|part| significant(f64::from(part) * self.per_unit(), 3));
                format!("walls      thinnest {} (at {x}, {y}, {z})", self.length(wall))
            }));
            lines
                .push(format!("overhang   {} of the area hangs over by more than 45 degrees", percent(facts.overhang)));
        }
        lines.join("\n") + "\n"
    }

    /// The facts as JSON: lengths in millimeters, or in world units of an object without a unit.
    pub fn json(&self) -> Value {
        let (unit, edges) = (self.per_unit(), &self.edges);
        let mut all = json!({
            "unit": if self.millimeters.is_some() { "mm" } else { "world" },
            "vertices": edges.vertices,
            "triangles": self.triangles,
            "watertight": edges.open + edges.crowded + edges.turned == 0,
            "bodies": edges.bodies,
            "dropped_bodies": self.dropped,
            "size": self.size.to_array().map(|side| f64::from(side) * unit),
            "volume": self.volume * unit.powi(3),
        });
        if let Some(SolidReport { proof, full, facts }) = &self.solid {
            all["full_triangles"] = json!(full);
            all["surface"] = json!({
                "within": proof.distance * unit,
                "proven_share": proof.share,
                "all_within": proof.largest.map(|largest| largest * unit),
                "lost_above": proof.lost * unit,
                "lost_places": proof.lost_samples,
                "self_intersections": proof.crossings,
            });
            all["thinnest_wall"] = json!(facts.thinnest.map(|(wall, place)| json!({
                "thickness": wall * unit,
                "place": place.to_array().map(|part| f64::from(part) * unit),
            })));
            all["overhang_share"] = json!(facts.overhang);
        }
        all
    }

    /// Line about bodies that are small beside the largest, or were dropped.
    fn specks(&self) -> Option<String> {
        let (bodies, dropped) = (&self.bodies, self.dropped);
        let least = SPECK * bodies.first().map_or(0.0, |body| body.volume);
        let small: Vec<&Body> = bodies[..bodies.len() - dropped].iter().filter(|body| body.volume < least).collect();
        let gone = (dropped > 0).then(|| format!("{dropped} smaller ones were dropped"));
        let left = small.first().map(|first| {
            let [x, y, z] = first.place.to_array().map(|part| significant(f64::from(part), 3));
            let (count, volume) = (small.len(), significant(first.volume, 3));
            format!(
                "{count} below 0.1% of the volume of the largest, of up to {volume} (at {x}, {y}, {z}); --smallest 0.1% drops them"
            )
        });
        let all: Vec<String> = gone.into_iter().chain(left).collect();
        (!all.is_empty()).then(|| all.join("; "))
    }

    /// Line about the size of a print.
    fn print(&self, format: MeshFormat) -> Option<String> {
        let [x, y, z] = self.size.to_array().map(|side| significant(f64::from(side) * self.per_unit(), 3));
        let why = match (self.millimeters, format) {
            (Some(size), _) => size.from.words(),
            (None, MeshFormat::Stl | MeshFormat::Obj | MeshFormat::ThreeMf) => {
                "as slicers read it; --scale-to 60mm sets the longest side of the object".into()
            }
            (None, _) => return None,
        };
        let volume = match self.millimeters {
            Some(size) => format!(", {} cm3", significant(self.volume * size.per_world_unit.powi(3) / 1000.0, 3)),
            None => String::new(),
        };
        Some(format!("{x} x {y} x {z} mm{volume}, {why}"))
    }
}

/// A part in percent, rounded down so that nothing less than all reads as 100.
fn percent(part: f64) -> String {
    format!("{} %", (1e4 * part).floor() / 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::render::UnitOrigin;

    fn report(bodies: &[f64], dropped: usize) -> Report {
        let body = |volume: &f64| Body { volume: *volume, triangles: 4, place: Vec3::new(1.0, 2.0, 3.0) };
        Report {
            size: Vec3::new(3.0, 2.0, 1.0),
            volume: 6.0,
            ..Report::of(&shape::Mesh::default(), bodies.iter().map(body).collect(), dropped)
        }
    }

    #[test]
    fn specks_are_counted_beside_the_largest() {
        let all = [2.0, 0.5, 1e-4, 1e-9];
        assert_eq!(report(&all[..2], 0).specks(), None);
        let two = report(&all, 0).specks().unwrap();
        assert!(two.starts_with("2 below 0.1% of the volume of the largest, of up to 0.0001 (at 1, 2, 3)"), "{two}");
        assert_eq!(report(&all, 2).specks().unwrap(), "2 smaller ones were dropped");
    }

    #[test]
    fn a_proof_is_stated_with_what_it_leaves_open() {
        let mut report = report(&[2.0], 0);
        report.millimeters =
            Some(Millimeters { per_object_unit: 30.0, per_world_unit: 20.0, from: UnitOrigin::ScaleTo });
        assert_eq!(report.print(MeshFormat::Ply).unwrap(), "60 x 40 x 20 mm, 48 cm3, by --scale-to");
        let proof =
            Proof { distance: 0.0025, share: 0.99996, largest: Some(0.005), lost: 0.02, lost_samples: 0, crossings: 0 };
        let facts = SolidFacts { walls: Vec::new(), thinnest: None, overhang: 0.125 };
        report.solid = Some(SolidReport { proof, full: 9, facts });
        assert_eq!(
            report.statement().unwrap(),
            "within 0.05 mm of 99.99 % of the area (proven), within 0.1 mm of all of it; no matter and no gap thicker than \
             0.4 mm is lost"
        );
        assert!(
            report
                .lines(MeshFormat::Stl)
                .ends_with("overhang   12.5 % of the area hangs over by more than 45 degrees\n")
        );
        let solid = report.solid.as_mut().unwrap();
        solid.proof = Proof { share: 1.0, largest: None, lost_samples: 3, crossings: 2, ..proof };
        assert_eq!(
            report.statement().unwrap(),
            "within 0.05 mm of all the area (proven); 3 places of matter or gaps are lost, each thicker than 0.05 mm; 2 \
             triangles pass through others"
        );
    }
}
