use super::*;
use crate::volume::rootness::{Rootness, rootness};
use ndarray::{Array3, Array4, Axis};

/// A smooth bright line through `p` along `t` (unit, x y z).
fn line(shape: (usize, usize, usize), p: [f32; 3], t: [f32; 3]) -> Array3<f32> {
    Array3::from_shape_fn(shape, |(k, j, i)| {
        let d = [i as f32 - p[0], j as f32 - p[1], k as f32 - p[2]];
        let along: f32 = (0..3).map(|c| d[c] * t[c]).sum();
        let away2: f32 = d.iter().map(|x| x * x).sum::<f32>() - along * along;
        (-away2 / 2.0).exp()
    })
}

fn whole(volume: &RootVolume, params: &Suppress) -> Ridges {
    let nz = volume.rootness.dim().0;
    suppress(volume, 0..nz, 0, nz, params).unwrap()
}

#[test]
fn the_crest_of_an_oblique_line_is_found_to_a_tenth_of_a_voxel() {
    let t = unit([0.3, 0.5, 0.8]);
    let p = [12.3, 11.8, 12.1];
    let params = Rootness { sigma: vec![1.0], ..Rootness::default() };
    let volume = rootness(line((24, 24, 24), p, t).view(), 1.0, &params).unwrap();
    for tangent in [Tangent::Directions13, Tangent::Continuous] {
        let ridges = whole(&volume, &Suppress { tangent });
        let mut seen = 0;
        for n in 0..ridges.len() {
            let [k, j, i] = ridges.voxel(n);
            if ridges.rootness[n] < 0.1 || [k, j, i].iter().any(|&x| !(5..19).contains(&x)) {
                continue;
            }
            let o = ridges.offset[n];
            let d = [i as f32 + o[0] - p[0], j as f32 + o[1] - p[1], k as f32 + o[2] - p[2]];
            let along: f32 = (0..3).map(|c| d[c] * t[c]).sum();
            let away = (d.iter().map(|x| x * x).sum::<f32>() - along * along).max(0.0).sqrt();
            // A neighbour across the quantised tangent may be off the crest by more than its parabola sees.
            assert!(away < 0.25, "{tangent:?}: {away} at {k} {j} {i}");
            let dot: f32 = (0..3).map(|c| ridges.tangent[n][c] * t[c]).sum();
            assert!(dot.abs() > 0.999, "{tangent:?}: tangent {:?}", ridges.tangent[n]);
            seen += 1;
        }
        assert!((10..60).contains(&seen), "{tangent:?}: {seen} voxels");
    }
}

#[test]
fn directions_13_equal_a_plain_reference() {
    let volume = noise((9, 8, 7));
    let got = whole(&volume, &Suppress::default());
    let mut expected = Vec::new();
    for ((k, j, i), &value) in volume.rootness.indexed_iter() {
        let t = [0, 1, 2].map(|c| f32::from(volume.tangent[[k, j, i, c]]));
        let d = crate::volume::orientation::ORIENTATIONS[nearest(unit(t))].map(isize::from);
        let mut greatest = f32::NEG_INFINITY;
        for (z, y, x) in (0..27).map(|n| (n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1)) {
            if x * d[0] + y * d[1] + z * d[2] == 0 {
                let at = [k.wrapping_add_signed(z), j.wrapping_add_signed(y), i.wrapping_add_signed(x)];
                greatest = greatest.max(volume.rootness.get(at).copied().unwrap_or(f32::NEG_INFINITY));
            }
        }
        if value > 0.0 && value >= greatest {
            expected.push(((k * 8 + j) * 7 + i) as u32);
        }
    }
    assert!(expected.len() > 20);
    assert_eq!(got.index, expected);
}

fn noise(shape: (usize, usize, usize)) -> RootVolume {
    let mut state = 1u32;
    let mut next = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    RootVolume {
        rootness: Array3::from_shape_simple_fn(shape, || {
            let v = next();
            if v < 0.1 {
                f32::NAN
            } else if v < 0.3 {
                0.0
            } else {
                v
            }
        }),
        tangent: Array4::from_shape_simple_fn((shape.0, shape.1, shape.2, 3), || (next() * 250.0 - 125.0) as i8),
        scale: Array3::zeros(shape),
    }
}

#[test]
fn slabs_equal_the_whole() {
    let volume = noise((11, 6, 7));
    for tangent in [Tangent::Directions13, Tangent::Continuous] {
        let params = Suppress { tangent };
        let expected = whole(&volume, &params);
        let mut got = Ridges { shape: [11, 6, 7], ..Ridges::default() };
        for (from, to) in [(0, 1), (1, 6), (6, 11)] {
            let (a, b) = (from.max(HALO) - HALO, (to + HALO).min(11));
            let slab = RootVolume {
                rootness: volume.rootness.slice_axis(Axis(0), (a..b).into()).to_owned(),
                tangent: volume.tangent.slice_axis(Axis(0), (a..b).into()).to_owned(),
                scale: volume.scale.slice_axis(Axis(0), (a..b).into()).to_owned(),
            };
            got.append(suppress(&slab, from - a..to - a, a, 11, &params).unwrap());
        }
        assert_eq!(got, expected);
    }
}
