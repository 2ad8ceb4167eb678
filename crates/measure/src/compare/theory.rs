//! Theory: the order at which the error of a scene must fall with its samples.
//!
//! Sources: the midpoint rule and the closed forms of `verify`; docs/accuracy.md, "Known limits".

use hypertexture::scene::{Curve, Integration, Scene};
use serde::Serialize;

/// The order of the error in theory.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Theory {
    /// The least and the highest order: two where parts of the picture have orders of their own.
    pub order: [f64; 2],
    /// Why, in words.
    pub why: &'static str,
}

impl Theory {
    const fn of(order: f64, why: &'static str) -> Option<Theory> {
        Some(Theory { order: [order; 2], why })
    }

    /// Whether an observed order, with half its interval, lies elsewhere. Without an interval nothing contradicts.
    pub fn contradicts(&self, order: f64, plus_minus: Option<f64>) -> bool {
        let off = (self.order[0] - order).max(order - self.order[1]);
        plus_minus.is_some_and(|half| off > half.max(SLACK))
    }
}

/// Orders that differ by less are the same: few samples are not yet in the asymptotic range.
const SLACK: f64 = 0.25;

/// The theory of a scene; `None` for bent rays, custom modules, and octaves that fade by the step.
pub fn theory(scene: &Scene) -> Option<Theory> {
    let (effect, points) = (&scene.effect, scene.quality.integration == Integration::Point);
    if effect.bandlimit == "clamp" {
        return None;
    }
    let opaque = effect.opacity == "perlin" && scene.transfer.stops.iter().any(|stop| stop.density >= 1.0);
    let stepped = scene.transfer.curve == Curve::Steps;
    match effect.classify.as_str() {
        "surface" => {
            Some(Theory { order: [1.0, 3.0], why: "3 where a surface is located within the step, 1 at its silhouette" })
        }
        "preintegrated" => Theory::of(2.0, "the density is linear within the step"),
        "soft" if effect.gradient == "three" => Theory::of(1.0, "one-sided differences for the gradient"),
        "soft" | "post" if stepped => Theory::of(1.0, "the transfer map has steps"),
        "soft" if !points => Theory::of(2.0, "the density is linear within the step"),
        "soft" if has_core(scene) => Theory::of(1.0, "a step cuts the hard core"),
        "post" | "pre" if effect.softness == "hard" => Theory::of(1.0, "a step cuts the hard surface"),
        "post" | "pre" if opaque => Theory::of(1.0, "the extinction is infinite where the density is 1"),
        "soft" | "post" | "pre" if scene.camera.clip.is_some() => Theory::of(1.0, "a step cuts the clipping plane"),
        "soft" if scene.has_several() => Theory::of(1.0, "a step cuts the borders of the objects"),
        "soft" | "post" | "pre" => Theory::of(2.0, "midpoint rule in smooth matter"),
        _ => None,
    }
}

/// Whether the inner iso-value lies in the object: there its hard region begins. The formulas are so deep; others are
/// taken to be deep enough.
fn has_core(scene: &Scene) -> bool {
    let object = &scene.object;
    let depth = match object.input.as_str() {
        "sphere" | "cube" if object.is_formula() => 1.0,
        "torus" if object.is_formula() => 0.3,
        _ => f32::INFINITY,
    };
    object.inner_iso > -depth
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::scene::preset;

    fn order(effect: &str, change: impl FnOnce(&mut Scene)) -> Option<[f64; 2]> {
        let mut scene = preset(effect).unwrap();
        change(&mut scene);
        theory(&scene).map(|theory| theory.order)
    }

    fn segments(scene: &mut Scene) {
        scene.quality.integration = Integration::Segment;
    }

    #[test]
    fn points_have_order_2_in_smooth_matter_and_1_at_hard_edges() {
        assert_eq!(order("flow", |_| ()), Some([2.0; 2]), "soft throughout");
        assert_eq!(order("flow", |scene| scene.object.inner_iso = 0.0), Some([1.0; 2]), "a core");
        assert_eq!(order("flow", |scene| scene.camera.clip = Some([0.0, 0.0, 1.0, 0.0])), Some([1.0; 2]));
        assert_eq!(order("fire", |_| ()), Some([1.0; 2]));
        assert_eq!(order("fire_ball", |_| ()), Some([2.0; 2]), "no density is 1");
        assert_eq!(order("fire_ball", |scene| scene.transfer.curve = Curve::Steps), Some([1.0; 2]));
        assert_eq!(order("fire_ball", |scene| scene.transfer.stops[5].density = 1.0), Some([1.0; 2]));
    }

    #[test]
    fn segments_have_order_2_and_located_surfaces_3() {
        assert_eq!(order("fire", segments), Some([2.0; 2]));
        assert_eq!(order("fire", |scene| scene.effect.gradient = "three".into()), Some([1.0; 2]));
        assert_eq!(order("lit", |_| ()), Some([1.0, 3.0]));
        assert_eq!(order("shells", |_| ()), Some([2.0; 2]));
        assert_eq!(order("blue_glass", |_| ()), None);
    }

    #[test]
    fn an_observation_contradicts_where_its_interval_lies_elsewhere() {
        let theory = Theory { order: [1.0, 3.0], why: "" };
        assert!(theory.contradicts(0.5, Some(0.3)) && theory.contradicts(3.6, Some(0.5)));
        assert!(!theory.contradicts(0.5, Some(0.6)) && !theory.contradicts(2.0, Some(0.1)));
        assert!(!theory.contradicts(0.8, Some(0.01)) && !theory.contradicts(9.0, None));
    }
}
