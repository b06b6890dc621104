//! Points of a reconstruction from a CSV table with the columns x_mm, y_mm, z_mm; others are ignored, but
//! with a root_id column consecutive rows of one root are a polyline, and with parent_id, order and diameter_mm beside
//! it a root.

use crate::error::{Error, Result};
use crate::evaluation::Found;
use crate::roots::Root;

/// What a table holds; mm, tank frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Points {
    /// Bare points.
    Bare(Vec<[f64; 3]>),
    /// One polyline per root.
    Lines(Vec<Vec<[f64; 3]>>),
    /// Roots with parents, orders and diameters.
    Roots(Vec<Root>),
}

impl Points {
    /// As the evaluation takes them.
    pub fn found(&self) -> Found<'_> {
        match self {
            Self::Bare(points) => Found::Points(points),
            Self::Lines(lines) => Found::Lines(lines),
            Self::Roots(roots) => Found::Roots(roots),
        }
    }
}

/// Reads the content of the table `name`.
///
/// # Errors
/// Names file, line and column: a missing column, a cell that is no finite number.
pub fn parse(name: &str, bytes: &[u8]) -> Result<Points> {
    let mut reader = csv::Reader::from_reader(bytes);
    let fault = |e: csv::Error| Error::failed(format!("`{name}` is no CSV table: {e}"));
    let header = reader.headers().map_err(fault)?.clone();
    let find = |column: &str| header.iter().position(|h| h.trim() == column);
    let mut columns = [0; 3];
    for (place, column) in columns.iter_mut().zip(["x_mm", "y_mm", "z_mm"]) {
        *place = find(column).ok_or_else(|| {
            Error::failed(format!("`{name}` has no column `{column}`"))
                .help("name root_voxels.csv or roots.csv of a result, or a table with x_mm, y_mm, z_mm")
        })?;
    }
    let id = find("root_id");
    let kin = id.and_then(|id| Some([id, find("parent_id")?, find("order")?, find("diameter_mm")?]));
    let (mut points, mut lines, mut roots) = (Vec::new(), Vec::<Vec<[f64; 3]>>::new(), Vec::<Root>::new());
    let mut last = None;
    for (n, record) in reader.records().enumerate() {
        let record = record.map_err(fault)?;
        let number = |column: usize| {
            let cell = record.get(column).unwrap_or_default().trim();
            cell.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| {
                Error::failed(format!(
                    "`{name}` line {}: `{cell}` in column `{}` is no finite number",
                    n + 2,
                    &header[column]
                ))
            })
        };
        let point = [number(columns[0])?, number(columns[1])?, number(columns[2])?];
        let Some(root) = id.and_then(|c| record.get(c)) else {
            points.push(point);
            continue;
        };
        let begins = last.as_deref() != Some(root);
        if begins {
            last = Some(root.to_owned());
        }
        if let Some([id, parent, order, diameter]) = kin {
            if begins {
                let (id, parent, order) = (number(id)? as i64, number(parent)? as i64, number(order)? as u32);
                roots.push(Root { id, parent, order, points_mm: Vec::new(), radii_mm: Vec::new() });
            }
            if let Some(root) = roots.last_mut() {
                root.points_mm.push(point);
                root.radii_mm.push(number(diameter)? / 2.0);
            }
        } else {
            if begins {
                lines.push(Vec::new());
            }
            if let Some(line) = lines.last_mut() {
                line.push(point);
            }
        }
    }
    Ok(match (kin, id) {
        (Some(_), _) => Points::Roots(roots),
        (None, Some(_)) => Points::Lines(lines),
        (None, None) => Points::Bare(points),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_and_polylines() {
        let bare = parse("a.csv", b"x_mm,y_mm,z_mm,rootness\n1,2,3,0.5\n").unwrap();
        assert_eq!(bare, Points::Bare(vec![[1.0, 2.0, 3.0]]));
        let lines = parse("a.csv", b"root_id,x_mm,y_mm,z_mm\n4,1,2,3\n4,1,2,4\n5,0,0,0\n").unwrap();
        assert_eq!(lines, Points::Lines(vec![vec![[1.0, 2.0, 3.0], [1.0, 2.0, 4.0]], vec![[0.0; 3]]]));
        let table =
            b"root_id,parent_id,order,x_mm,y_mm,z_mm,diameter_mm\n0,-1,0,1,2,3,2\n0,-1,0,1,2,4,1\n3,0,1,0,0,0,1\n";
        let Points::Roots(roots) = parse("a.csv", table).unwrap() else { panic!("roots") };
        assert_eq!((roots.len(), roots[0].radii_mm.clone()), (2, vec![1.0, 0.5]));
        assert_eq!((roots[1].id, roots[1].parent, roots[1].order), (3, 0, 1));
    }

    #[test]
    fn faults_name_line_and_column() {
        let e = parse("a.csv", b"x_mm,y_mm,z_mm\n1,2,3\n1,NaN,3\n").unwrap_err();
        assert!(e.message.contains("line 3") && e.message.contains("y_mm"), "{e}");
        assert!(parse("a.csv", b"x,y\n1,2\n").unwrap_err().message.contains("x_mm"));
        assert!(parse("a.csv", b"").is_err());
    }
}
