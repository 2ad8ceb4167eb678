//! Brushes that paint a groom.

use super::Groom;
use glam::Vec3;

/// A brush: a ball whose strength falls off from its middle to its rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brush {
    /// Effect on the channels.
    pub kind: BrushKind,
    /// Radius, object units.
    pub radius: f32,
    /// Part of the full effect that one touch has in the middle, 0 to 1.
    pub strength: f32,
    /// Color of [`BrushKind::Color`], linear RGB.
    pub color: [f32; 3],
    /// Whether it also paints on the other side of the plane x = 0.
    pub mirrored: bool,
}

/// Effect of a brush.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BrushKind {
    /// Lays strands along the motion.
    #[default]
    Comb,
    /// Shortens.
    Cut,
    /// Lengthens.
    Grow,
    /// Lowers the density.
    Thin,
    /// Raises the density.
    Thicken,
    /// Weakens warps and DMFs.
    Weaken,
    /// Strengthens warps and DMFs.
    Strengthen,
    /// Colors.
    Color,
    /// Evens out all channels.
    Smooth,
    /// Removes all paint.
    Erase,
}

impl BrushKind {
    /// All kinds with name and description.
    pub const ALL: [(BrushKind, &str, &str); 10] = [
        (BrushKind::Comb, "comb", "Lays strands along the motion of the pointer."),
        (BrushKind::Cut, "cut", "Shortens."),
        (BrushKind::Grow, "grow", "Lengthens, up to twice the length of the effect, within its soft region."),
        (BrushKind::Thin, "thin", "Lowers the density."),
        (BrushKind::Thicken, "thicken", "Raises the density."),
        (BrushKind::Weaken, "weaken", "Lowers the amount of the effect, down to none."),
        (BrushKind::Strengthen, "strengthen", "Raises the amount of the effect, up to twice."),
        (BrushKind::Color, "color", "Colors."),
        (BrushKind::Smooth, "smooth", "Evens out what is painted."),
        (BrushKind::Erase, "erase", "Removes what is painted."),
    ];
}

impl Brush {
    /// Part of the strength at a distance from the middle, in radii: 1 to 0, flat at both ends.
    pub(crate) fn fall_off(part: f32) -> f32 {
        let rest = (1.0 - part * part).max(0.0);
        rest * rest
    }

    /// Touches a place of the surface, with its unit normal; `motion` is that of the brush since the last touch.
    pub fn touch(&self, groom: &mut Groom, at: Vec3, normal: Vec3, motion: Vec3) {
        self.paint(groom, at, normal, motion);
        if self.mirrored {
            let [at, normal, motion] = [at, normal, motion].map(|v| Vec3::new(-v.x, v.y, v.z));
            self.paint(groom, at, normal, motion);
        }
    }

    fn paint(&self, groom: &mut Groom, at: Vec3, normal: Vec3, motion: Vec3) {
        let voxels: Vec<usize> = groom.around(at, self.radius).collect();
        let tangent = (motion - motion.dot(normal) * normal).normalize_or_zero();
        let mean = if self.kind == BrushKind::Smooth { self.mean(groom, at, &voxels) } else { Groom::NEUTRAL };
        for index in voxels {
            let weight = self.strength * Brush::fall_off(groom.place(index).distance(at) / self.radius);
            let own = groom.at(index);
            let mut wanted = own;
            match self.kind {
                BrushKind::Comb if tangent == Vec3::ZERO => continue,
                BrushKind::Comb => wanted[5..8].copy_from_slice(&tangent.to_array()),
                BrushKind::Cut => wanted[0] = 0.0,
                BrushKind::Grow => wanted[0] = 2.0,
                BrushKind::Thin => wanted[1] = 0.0,
                BrushKind::Thicken => wanted[1] = 2.0,
                BrushKind::Weaken => wanted[8] = 0.0,
                BrushKind::Strengthen => wanted[8] = 2.0,
                BrushKind::Color => wanted[2..5].copy_from_slice(&self.color.map(|channel| 2.0 * channel)),
                BrushKind::Smooth | BrushKind::Erase => wanted = mean,
            }
            groom.set(index, std::array::from_fn(|channel| own[channel] + weight * (wanted[channel] - own[channel])));
        }
    }

    /// Weighted mean of the channels.
    fn mean(&self, groom: &Groom, at: Vec3, voxels: &[usize]) -> [f32; 9] {
        let (mut sum, mut all) = ([0.0; 9], 1e-12);
        for index in voxels {
            let weight = Brush::fall_off(groom.place(*index).distance(at) / self.radius);
            groom.at(*index).into_iter().zip(&mut sum).for_each(|(channel, sum)| *sum += weight * channel);
            all += weight;
        }
        sum.map(|sum| sum / all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn painted(kind: BrushKind, mirrored: bool, before: [f32; 9]) -> Groom {
        let mut groom = Groom::unpainted("sphere", 32);
        (0..groom.voxels()).for_each(|index| groom.set(index, before));
        let brush = Brush { kind, radius: 0.4, strength: 0.5, color: [1.0, 0.25, 0.0], mirrored };
        brush.touch(&mut groom, Vec3::new(0.6, 0.8, 0.0), Vec3::new(0.6, 0.8, 0.0), Vec3::Z + Vec3::new(0.6, 0.8, 0.0));
        groom
    }

    #[test]
    fn a_touch_changes_channels_by_its_fall_off_within_a_radius() {
        let before = [0.5, 1.5, 0.75, 1.0, 1.25, 0.25, 0.0, -0.5, 0.5];
        let wanted: [(BrushKind, [f32; 9]); 9] = [
            (BrushKind::Comb, [0.5, 1.5, 0.75, 1.0, 1.25, 0.0, 0.0, 1.0, 0.5]),
            (BrushKind::Cut, [0.0, 1.5, 0.75, 1.0, 1.25, 0.25, 0.0, -0.5, 0.5]),
            (BrushKind::Grow, [2.0, 1.5, 0.75, 1.0, 1.25, 0.25, 0.0, -0.5, 0.5]),
            (BrushKind::Thin, [0.5, 0.0, 0.75, 1.0, 1.25, 0.25, 0.0, -0.5, 0.5]),
            (BrushKind::Thicken, [0.5, 2.0, 0.75, 1.0, 1.25, 0.25, 0.0, -0.5, 0.5]),
            (BrushKind::Color, [0.5, 1.5, 2.0, 0.5, 0.0, 0.25, 0.0, -0.5, 0.5]),
            (BrushKind::Weaken, [0.5, 1.5, 0.75, 1.0, 1.25, 0.25, 0.0, -0.5, 0.0]),
            (BrushKind::Strengthen, [0.5, 1.5, 0.75, 1.0, 1.25, 0.25, 0.0, -0.5, 2.0]),
            (BrushKind::Erase, Groom::NEUTRAL),
        ];
        for (kind, wanted) in wanted {
            let groom = painted(kind, false, before);
            for index in 0..groom.voxels() {
                let part = groom.place(index).distance(Vec3::new(0.6, 0.8, 0.0)) / 0.4;
                let weight = if part < 1.0 { 0.5 * (1.0 - part * part).powi(2) } else { 0.0 };
                for channel in 0..9 {
                    let expected = before[channel] + weight * (wanted[channel] - before[channel]);
                    let found = groom.at(index)[channel];
                    assert!((found - expected).abs() < 2e-3, "{kind:?} {channel}: {found}, not {expected}");
                }
            }
        }
        assert_eq!(painted(BrushKind::Smooth, false, before), painted(BrushKind::Smooth, true, before));
    }

    #[test]
    fn a_mirrored_touch_is_one_on_both_sides() {
        let groom = painted(BrushKind::Comb, true, Groom::NEUTRAL);
        for index in 0..groom.voxels() {
            let other = (index / 32) * 32 + 31 - index % 32;
            let [mut own, other] = [groom.at(index), groom.at(other)];
            own[5] = -own[5];
            assert_eq!(own, other);
        }
    }
}
