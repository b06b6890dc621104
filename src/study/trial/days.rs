//! The days of a plant: its belts, where each day stands to the first, and its roots over all of them.

use crate::flow::NodeId;
use crate::stages::align::Align;
use crate::stages::follow::Follow;
use crate::stages::print::Print;
use crate::stages::recall::Recall;
use crate::stages::recalled::Recalled;
use crate::study::batch::Batch;
use crate::study::plants::Capture;
use std::collections::BTreeMap;

/// A plant that was photographed on several days.
pub struct Days {
    /// The plant.
    pub plant: String,
    /// Places of its captures among those of the trial, by date.
    pub captures: Vec<usize>,
    /// Its roots over days.
    pub follow: NodeId,
}

/// Adds the nodes of all plants with several days; `captures` run as the batch's studies, which are no sweeps.
pub(super) fn add(batch: &mut Batch, captures: &[Capture]) -> Vec<Days> {
    let mut of_plants: BTreeMap<&str, Vec<(f64, usize)>> = BTreeMap::new();
    for (n, capture) in captures.iter().enumerate() {
        if let (Some(date), Some(study)) = (&capture.date, batch.studies.get(n))
            && !study.is_sweep()
        {
            of_plants.entry(&capture.plant).or_default().push((date.days, n));
        }
    }
    let mut all = Vec::new();
    for (plant, mut dated) in of_plants {
        dated.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Two captures of one moment are no days.
        if dated.len() < 2 || dated.windows(2).any(|pair| pair[0].0 >= pair[1].0) {
            continue;
        }
        let Some(follow) = of_plant(batch, plant, &dated, captures) else { continue };
        all.push(Days {
            plant: plant.to_owned(),
            captures: dated.iter().map(|(_, n)| *n).collect(),
            follow: recalled(batch, plant, &dated, captures, follow).unwrap_or(follow),
        });
    }
    all
}

fn of_plant(batch: &mut Batch, plant: &str, dated: &[(f64, usize)], captures: &[Capture]) -> Option<NodeId> {
    let (mut systems, mut prints, mut params) = (Vec::new(), Vec::new(), None);
    for &(_, n) in dated {
        let Batch { graph, studies, .. } = batch;
        let (settings, nodes) = studies[n].points.first()?.planned.as_ref().ok()?;
        systems.push(nodes.system);
        params.get_or_insert_with(|| settings.follow.clone());
        let (photos, cameras): (Vec<NodeId>, Vec<NodeId>) = nodes.seen.iter().copied().unzip();
        let print = Print::of(&settings.tank, settings.pose.print_thickness_mm);
        let label = format!("print/{}", captures[n].name());
        let ports = [("photos", &photos[..]), ("cameras", &cameras)];
        prints.push((settings.tank.belts_mm.clone(), graph.add(&label, print, &ports)));
    }
    // Tanks without belts, or with others, have nothing to be laid upon each other.
    let [(belts, reference), later @ ..] = &prints[..] else { return None };
    let comparable = !belts.is_empty() && later.iter().all(|(other, _)| other == belts);
    let alignments: Vec<NodeId> = later
        .iter()
        .zip(&dated[1..])
        .filter(|_| comparable)
        .map(|((_, print), (_, n))| {
            let label = format!("align/{}", captures[*n].name());
            batch.graph.add(&label, Align {}, &[("reference", &[*reference]), ("later", &[*print])])
        })
        .collect();
    let stage = Follow { days: times(dated), params: params? };
    let ports = [("systems", &systems[..]), ("alignments", &alignments)];
    Some(batch.graph.add(&format!("follow/{plant}"), stage, &ports))
}

/// Days since the first.
fn times(dated: &[(f64, usize)]) -> Vec<f64> {
    dated.iter().map(|(days, _)| days - dated[0].0).collect()
}

/// Where the days that ask for it are helped by the others, the roots with those found so; each day's search is a node of its own.
fn recalled(
    batch: &mut Batch,
    plant: &str,
    dated: &[(f64, usize)],
    captures: &[Capture],
    follow: NodeId,
) -> Option<NodeId> {
    let (mut found, mut params) = (Vec::new(), None);
    for (day, &(_, n)) in dated.iter().enumerate() {
        let Batch { graph, studies, .. } = batch;
        let (settings, nodes) = studies[n].points.first()?.planned.as_ref().ok()?;
        params.get_or_insert_with(|| settings.follow.clone());
        if !settings.recall.enabled {
            continue;
        }
        let cameras: Vec<NodeId> = nodes.seen.iter().map(|(_, camera)| *camera).collect();
        let stage = Recall {
            day,
            tank: settings.tank.clone(),
            blur_mm: settings.contrast.blur_mm,
            params: settings.recall.clone(),
        };
        let ports = [("followed", &[follow][..]), ("evidence", &nodes.evidence), ("cameras", &cameras)];
        found.push(graph.add(&format!("recall/{}", captures[n].name()), stage, &ports));
    }
    if found.is_empty() {
        return None;
    }
    let stage = Recalled { days: times(dated), params: params? };
    Some(batch.graph.add(&format!("recalled/{plant}"), stage, &[("followed", &[follow][..]), ("recalled", &found)]))
}
