//! Arrays come back as they went in, and their digests depend on the values alone.

use std::sync::{Arc, Mutex};

use ndarray::{Array2, ArrayD, Axis, IxDyn, Slice};
use proptest::prelude::*;

use super::array::{ArrayReader, SlabWriter};
use super::digest::{ArrayHasher, Digest};
use super::element::{Dtype, Element};
use super::manifest::{Member, MemberKind, digest_of};

fn names(rank: usize) -> Vec<&'static str> {
    ["t", "z", "y", "x", "c"][..rank].to_vec()
}

/// Writes `values` in slabs of the given depths (the last one repeated) and gives the digest.
fn write<T: Element>(folder: &std::path::Path, values: &ArrayD<T>, depths: &[usize]) -> Digest {
    let found = Arc::new(Mutex::new(None));
    let told = found.clone();
    let done = move |digest| {
        *told.lock().unwrap() = Some(digest);
        Ok(())
    };
    let mut writer = SlabWriter::<T>::create(folder, values.shape(), &names(values.ndim()), Box::new(done)).unwrap();
    let (mut row, mut depths, mut depth) = (0, depths.iter(), 1);
    while row < values.shape()[0] {
        depth = depths.next().copied().unwrap_or(depth);
        let end = (row + depth).min(values.shape()[0]);
        writer.push(values.slice_axis(Axis(0), Slice::from(row..end))).unwrap();
        row = end;
    }
    writer.finish().unwrap();
    let digest = found.lock().unwrap().take();
    digest.unwrap()
}

fn digest<T: Element>(values: &ArrayD<T>) -> Digest {
    let mut hasher = ArrayHasher::default();
    hasher.update(values.view());
    hasher.finish()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn slabs_of_any_depth_give_the_array_and_its_digest(
        shape in prop::collection::vec(0_usize..40, 1..5),
        depths in prop::collection::vec(1_usize..17, 1..4),
        seed in any::<u32>(),
        cut in 0.0_f64..1.0,
    ) {
        let mut state = seed;
        let values = ArrayD::from_shape_simple_fn(IxDyn(&shape), || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if state >> 28 == 0 { f32::NAN } else { (state >> 8) as f32 }
        });
        let dir = tempfile::tempdir().unwrap();
        prop_assert_eq!(write(dir.path(), &values, &depths), digest(&values));
        let reader = ArrayReader::<f32>::open(dir.path(), &shape).unwrap();
        let bits = |a: &ArrayD<f32>| a.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let back = reader.read().unwrap();
        prop_assert_eq!(back.shape(), &shape[..]);
        prop_assert_eq!(bits(&back), bits(&values));
        let from = (cut * shape[0] as f64) as usize;
        let slab = reader.slab(from..shape[0]).unwrap();
        prop_assert_eq!(bits(&slab), bits(&values.slice_axis(Axis(0), Slice::from(from..)).to_owned()));
    }
}

#[test]
fn an_array_larger_than_a_shard_comes_back() {
    let values = ArrayD::from_shape_fn(IxDyn(&[70, 700, 700, 3]), |i| (i[0] * 31 + i[1] * 7 + i[2] * 3 + i[3]) as u8);
    let dir = tempfile::tempdir().unwrap();
    assert_eq!(write(dir.path(), &values, &[11]), digest(&values));
    let shards = std::fs::read_dir(dir.path().join("c")).unwrap().count();
    assert_eq!(shards, 2);
    let reader = ArrayReader::<u8>::open(dir.path(), values.shape()).unwrap();
    assert_eq!(reader.slab(35..60).unwrap(), values.slice_axis(Axis(0), Slice::from(35..60)));
    assert_eq!(reader.read().unwrap(), values);
}

#[test]
fn the_layout_in_memory_and_the_payload_of_nan_leave_no_trace() {
    let values = Array2::from_shape_fn((5, 7), |(y, x)| (y * 10 + x) as f64);
    let turned = values.t().as_standard_layout().to_owned();
    assert_eq!(digest(&values.clone().into_dyn()), digest(&turned.t().to_owned().into_dyn()));
    let nan = |bits| ArrayD::from_elem(IxDyn(&[2]), f32::from_bits(bits));
    assert_eq!(digest(&nan(0x7fc0_0000)), digest(&nan(0xffc0_1234)));
    let zero = |v: f32| ArrayD::from_elem(IxDyn(&[2]), v);
    assert_ne!(digest(&zero(0.0)), digest(&zero(-0.0)));
}

#[test]
fn the_same_array_is_encoded_to_the_same_bytes() {
    let values = ArrayD::from_shape_fn(IxDyn(&[33, 150, 150]), |i| (i[0] * i[1] % 17 + i[2]) as f32);
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    write(one.path(), &values, &[33]);
    write(two.path(), &values, &[4, 9]);
    for name in ["zarr.json", "c/0/0/0"] {
        assert_eq!(std::fs::read(one.path().join(name)).unwrap(), std::fs::read(two.path().join(name)).unwrap());
    }
}

#[test]
fn rows_too_few_or_of_another_shape_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let mut writer = SlabWriter::<u8>::create(dir.path(), &[3, 4], &["y", "x"], Box::new(|_| Ok(()))).unwrap();
    assert!(writer.push(ArrayD::zeros(IxDyn(&[1, 5])).view()).is_err());
    assert!(writer.push(ArrayD::zeros(IxDyn(&[4, 4])).view()).is_err());
    writer.push(ArrayD::zeros(IxDyn(&[2, 4])).view()).unwrap();
    let error = writer.finish().unwrap_err().to_string();
    assert!(error.contains("was given 2 of its 3 rows"), "{error}");
}

#[test]
fn the_digest_of_an_artefact_is_pinned() {
    let values = ArrayD::from_shape_fn(IxDyn(&[2, 3]), |i| i[0] as f32 - 0.5 * i[1] as f32);
    let array = Member {
        name: "volume".into(),
        kind: MemberKind::Array,
        dtype: Some(Dtype::Float32),
        shape: vec![2, 3],
        digest: digest(&values),
        bytes: 1,
    };
    let text = Member {
        name: "note.txt".into(),
        kind: MemberKind::Bytes,
        dtype: None,
        shape: Vec::new(),
        digest: Digest::of(b"hello"),
        bytes: 5,
    };
    let both = digest_of(&[array.clone(), text.clone()]);
    assert_eq!(both, digest_of(&[text, Member { bytes: 9, ..array }]), "neither order nor size on disk count");
    assert_eq!(
        both.to_string(),
        "a58998ae14ccf780d055d6d6a44ce0f17d89b328f16301893b231908cf21ddea",
        "the form of digests changed: every store would miss; if that is meant, raise the store's FORMAT"
    );
}

#[test]
fn another_shape_or_fill_value_than_was_written_is_damage() {
    let values = ArrayD::<f32>::zeros(IxDyn(&[4, 5]));
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), &values, &[4]);
    let open = |shape: &[usize]| ArrayReader::<f32>::open(dir.path(), shape).map(drop).map_err(|e| e.message);
    open(&[4, 5]).unwrap();
    assert!(open(&[3, 5]).is_err_and(|text| text.contains("not what was written")));
    let path = dir.path().join("zarr.json");
    let text = std::fs::read_to_string(&path).unwrap();
    let found: serde_json::Value = serde_json::from_str(&text).unwrap();
    let fill = serde_json::to_string(&found["fill_value"]).unwrap();
    let other = text.replace(&format!("\"fill_value\": {fill}"), "\"fill_value\": 7.0");
    assert_ne!(other, text);
    std::fs::write(&path, other).unwrap();
    assert!(open(&[4, 5]).is_err_and(|text| text.contains("not what was written")));
}
