//! Sets the base of the plant: the root that starts at a given end has order 0, and orders are counted from it.
//!
//! Along the way from there to the old base everything hangs the other way round: a root that the new base sprang from is cut where it
//! sprang, and both its halves spring from the new one.

use super::Done;
use super::tree::Tree;
use crate::optics::Vec3;
use crate::roots::strand::End;

/// Makes the end at a place the base.
pub(super) fn rebase(tree: &mut Tree, at: &Vec3, within_mm: f64) -> Done {
    let (spot, end) = tree.end_at(at, within_mm)?;
    let found = tree.told(&spot);
    let base = tree.roots[spot.root].root.id;
    let mut hung = (tree.roots[spot.root].root.parent, Vec3::from(tree.roots[spot.root].root.points_mm[0]));
    tree.roots[spot.root].root.parent = -1;
    if end == End::Last {
        tree.reverse(spot.root);
    }
    let mut under = base;
    while let Some(parent) = tree.index(hung.0) {
        let line = &tree.roots[parent].root;
        let (place, last) = (super::nearest::nearest(&line.points_mm, &hung.1).0, line.points_mm.len() - 1);
        let radius_mm = line.radii_mm[place];
        let next = (line.parent, Vec3::from(line.points_mm[0]));
        let id = line.id;
        let near = |k: usize| (Vec3::from(line.points_mm[k]) - Vec3::from(line.points_mm[place])).norm() <= radius_mm;
        let (at_base, at_tip) = (place == 0 || near(0), place == last || near(last));
        if at_base {
            tree.roots[parent].root.parent = under;
        } else if at_tip {
            tree.reverse(parent);
            tree.roots[parent].root.parent = under;
        } else if let Some(beyond) = tree.split(parent, place) {
            tree.roots[beyond].root.parent = under;
            tree.reverse(parent);
            tree.roots[parent].root.parent = under;
        }
        // A root that hung at the very base of its parent hangs with it on the new one.
        under = if at_base { under } else { id };
        hung = next;
    }
    let others: Vec<usize> = (0..tree.roots.len())
        .filter(|&n| tree.roots[n].root.parent < 0 && tree.roots[n].root.order == 0 && tree.roots[n].root.id != base)
        .collect();
    others.into_iter().for_each(|n| tree.set_order(n, 1));
    count(tree, base);
    Ok((*at, format!("{found}; now the base")))
}

/// Counts orders from the base.
fn count(tree: &mut Tree, base: i64) {
    let mut ring = vec![(base, 0)];
    while let Some((id, order)) = ring.pop() {
        for r in &mut tree.roots {
            if r.root.id == id {
                r.root.order = order;
            } else if r.root.parent == id {
                ring.push((r.root.id, order + 1));
            }
        }
    }
}
