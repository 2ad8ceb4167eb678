//! Emission and absorption along a piece of a ray.

/// Sample of a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Matter {
    /// Linear RGB.
    pub(super) color: [f64; 3],
    /// Extinction per depth; infinite in the hard region.
    pub(super) extinction: f64,
}

/// Emitted light and transmittance of a piece of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Transport {
    pub(super) color: [f64; 3],
    pub(super) transmittance: f64,
}

impl Transport {
    /// An empty piece.
    pub(super) const CLEAR: Transport = Transport { color: [0.0; 3], transmittance: 1.0 };

    /// This piece followed by another.
    pub(super) fn then(self, behind: Transport) -> Transport {
        let color = std::array::from_fn(|c| self.color[c] + self.transmittance * behind.color[c]);
        Transport { color, transmittance: self.transmittance * behind.transmittance }
    }

    /// Largest difference of any channel, opacity included.
    pub(super) fn differs(self, other: Transport) -> f64 {
        let colors = (0..3).map(|c| (self.color[c] - other.color[c]).abs());
        colors.fold((self.transmittance - other.transmittance).abs(), f64::max)
    }

    /// A piece of length `length` by its ends and its middle. Of three samples of which the first is opaque nothing but
    /// its color is seen; one that becomes opaque farther on is taken as opaque from its middle or its end on.
    pub(super) fn of([near, middle, far]: [Matter; 3], length: f64) -> Transport {
        let opaque = |matter: Matter| Transport { color: matter.color, transmittance: 0.0 };
        if near.extinction.is_infinite() {
            return opaque(near);
        }
        if middle.extinction.is_infinite() {
            return Transport::even(near, 0.5 * length).then(opaque(middle));
        }
        if far.extinction.is_infinite() {
            return Transport::even(middle, length).then(opaque(far));
        }
        // Optical depths of both halves by the parabola through the three extinctions; never negative.
        let [e0, e1, e2] = [near, middle, far].map(|matter| matter.extinction);
        let depth = length / 6.0 * (e0 + 4.0 * e1 + e2);
        if depth <= 0.0 {
            return Transport::CLEAR;
        }
        let half = (length / 24.0 * (5.0 * e0 + 8.0 * e1 - e2)).clamp(0.0, depth);
        // Light of each sample, attenuated by the matter between it and the first sample with light.
        let depths = [(e0, 0.0), (4.0 * e1, half), (e2, depth)];
        let first = depths.iter().find(|(shines, _)| *shines > 0.0).map_or(0.0, |(_, depth)| *depth);
        let weights = depths.map(|(shines, depth)| shines * (first - depth).min(0.0).exp());
        let sum: f64 = weights.iter().sum();
        let alpha = -(-depth).exp_m1();
        let mixed = |c: usize| {
            let colors = [near.color[c], middle.color[c], far.color[c]];
            colors.iter().zip(weights).map(|(color, weight)| color * weight).sum::<f64>() / sum
        };
        Transport { color: std::array::from_fn(|c| alpha * mixed(c)), transmittance: (-depth).exp() }
    }

    fn even(matter: Matter, length: f64) -> Transport {
        let transmittance = (-matter.extinction * length).exp();
        Transport { color: matter.color.map(|color| (1.0 - transmittance) * color), transmittance }
    }
}
