//! Many copies at places that a seed makes.

use glam::{DAffine3, DQuat, DVec3, EulerRot};

use super::error::Fault;
use super::spec::ScatterSpec;

/// Most copies of one scatter.
const MOST: u32 = 100_000;
/// Most copies that keep a distance: each place is held against all others.
const MOST_SPACED: u32 = 5_000;
/// Places that are tried for each copy, where they keep a distance.
const TRIES: u64 = 30;

/// Numbers in [0, 1) that depend on seed and place in the sequence alone (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: DVec3, high: DVec3) -> DVec3 {
        let share = DVec3::new(self.next(), self.next(), self.next());
        low + share * (high - low)
    }
}

/// The maps of all copies: uniform in a box, each turned and scaled by chance, none nearer to another than the spacing.
pub(super) fn placements(spec: &ScatterSpec) -> Result<Vec<DAffine3>, Fault> {
    let [low, high] = [spec.from, spec.to].map(DVec3::from_array);
    let turn = DVec3::from_array(spec.turn_deg.unwrap_or_default());
    let [least, most] = spec.scale.unwrap_or([1.0, 1.0]);
    if spec.count > MOST {
        return Fault::says(format!("a scatter has at most {MOST} copies"));
    }
    if !(low.is_finite() && high.is_finite() && turn.is_finite() && spec.spacing >= 0.0) {
        return Fault::says("from, to and turn_deg of a scatter must be finite, its spacing not negative");
    }
    if !(least > 0.0 && least <= most && most.is_finite()) {
        return Fault::says("scale of a scatter is [least, most], both positive");
    }
    if spec.spacing > 0.0 && spec.count > MOST_SPACED {
        return Fault::says(format!(
            "a scatter with spacing has at most {MOST_SPACED} copies; split it, or leave spacing out"
        ));
    }
    let mut numbers = Numbers(spec.seed);
    let mut places: Vec<DVec3> = Vec::new();
    let mut maps = Vec::new();
    for _ in 0..TRIES * u64::from(spec.count) {
        if maps.len() == spec.count as usize {
            break;
        }
        let place = numbers.between(low, high);
        let angles = numbers.between(-turn, turn);
        let scale = least * (most / least).powf(numbers.next());
        if spec.spacing > 0.0 && places.iter().any(|other| other.distance(place) < spec.spacing) {
            continue;
        }
        let [x, y, z] = angles.to_array().map(f64::to_radians);
        let quat = DQuat::from_euler(EulerRot::YXZ, y, x, z);
        maps.push(DAffine3::from_scale_rotation_translation(DVec3::splat(scale), quat, place));
        places.push(place);
    }
    if maps.len() < spec.count as usize {
        let found = maps.len();
        return Fault::says(format!("only {found} of {} copies fit with that spacing", spec.count));
    }
    Ok(maps)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec() -> ScatterSpec {
        ScatterSpec {
            count: 200,
            seed: 5,
            from: [-4.0, 0.0, 1.0],
            to: [4.0, 0.0, 9.0],
            turn_deg: Some([0.0, 180.0, 10.0]),
            scale: Some([0.5, 2.0]),
            spacing: 0.3,
        }
    }

    #[test]
    fn copies_keep_to_their_box_and_their_distance() {
        let maps = placements(&spec()).unwrap();
        assert_eq!(maps.len(), 200);
        for (i, map) in maps.iter().enumerate() {
            let place = map.translation;
            assert!(place.x.abs() <= 4.0 && place.y == 0.0 && (1.0..=9.0).contains(&place.z), "{place}");
            assert!(maps[..i].iter().all(|other| other.translation.distance(place) >= 0.3));
            let scale = map.matrix3.x_axis.length();
            assert!((0.5..=2.0).contains(&scale), "{scale}");
        }
        // The same seed, the same places
        assert_eq!(maps, placements(&spec()).unwrap());
        assert_ne!(maps, placements(&ScatterSpec { seed: 6, ..spec() }).unwrap());
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert!(placements(&ScatterSpec { spacing: 3.0, ..spec() }).is_err());
        assert!(placements(&ScatterSpec { count: 1 << 30, ..spec() }).is_err());
        assert!(placements(&ScatterSpec { count: MOST_SPACED + 1, spacing: 1e-9, ..spec() }).is_err());
        assert!(placements(&ScatterSpec { from: [f64::NAN; 3], ..spec() }).is_err());
        assert!(placements(&ScatterSpec { scale: Some([0.0, 1.0]), ..spec() }).is_err());
    }
}
