//! Points of a reconstruction from a CSV table with the columns x_mm, y_mm, z_mm; others are ignored, but
//! with a root_id column consecutive rows of one root are a polyline, and with parent_id, order and diameter_mm too they
//! are roots.

use crate::error::{Error, Result};
use crate::roots::Root;

/// What a table holds; mm, tank frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Points {
    /// Bare points.
    Bare(Vec<[f64; 3]>),
    /// One polyline per root.
    Lines(Vec<Vec<[f64; 3]>>),
    /// Roots.
    Roots(Vec<Root>),
}

/// The columns that make a table of points one of roots.
const OF_ROOTS: [&str; 4] = ["root_id", "parent_id", "order", "diameter_mm"];

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
    let of_roots: Option<Vec<usize>> = OF_ROOTS.iter().map(|c| find(c)).collect();
    let mut roots: Vec<Root> = Vec::new();
    let mut points = Vec::new();
    let mut lines: Vec<Vec<[f64; 3]>> = Vec::new();
    let mut last = None;
    for (n, record) in reader.records().enumerate() {
        let record = record.map_err(fault)?;
        let number = |column: usize| {
            let cell = record.get(column).unwrap_or_default().trim();
            cell.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| {
                let (line, column) = (n + 2, &header[column]);
                Error::failed(format!("`{name}` line {line}: `{cell}` in column `{column}` is no finite number"))
            })
        };
        let mut point = [0.0; 3];
        for (value, &column) in point.iter_mut().zip(&columns) {
            *value = number(column)?;
        }
        if let Some(&[id, parent, order, diameter]) = of_roots.as_deref() {
            let (id, radius_mm) = (number(id)? as i64, 0.5 * number(diameter)?);
            if roots.last().is_none_or(|r| r.id != id) {
                let (parent, order) = (number(parent)? as i64, number(order)?.max(0.0) as u32);
                roots.push(Root { id, parent, order, points_mm: Vec::new(), radii_mm: Vec::new() });
            }
            if let Some(root) = roots.last_mut() {
                root.points_mm.push(point);
                root.radii_mm.push(radius_mm);
            }
            continue;
        }
        match id.and_then(|c| record.get(c)) {
            None => points.push(point),
            Some(root) => {
                if last.as_deref() != Some(root) {
                    lines.push(Vec::new());
                    last = Some(root.to_owned());
                }
                if let Some(line) = lines.last_mut() {
                    line.push(point);
                }
            }
        }
    }
    if of_roots.is_some() {
        return Ok(Points::Roots(roots));
    }
    Ok(if id.is_some() { Points::Lines(lines) } else { Points::Bare(points) })
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
    }

    #[test]
    fn roots_with_orders_and_diameters() {
        let table = b"root_id,parent_id,order,x_mm,y_mm,z_mm,diameter_mm\n0,-1,0,1,2,3,2\n0,-1,0,1,2,4,1\n1,0,1,0,0,0,1\n";
        let Points::Roots(roots) = parse("a.csv", table).unwrap() else { panic!("roots") };
        assert_eq!((roots.len(), roots[1].parent, roots[1].order), (2, 0, 1));
        assert_eq!((roots[0].points_mm[1], roots[0].radii_mm[0]), ([1.0, 2.0, 4.0], 1.0));
        assert!(parse("a.csv", b"root_id,parent_id,order,x_mm,y_mm,z_mm,diameter_mm\n0,-1,0,1,2,3,x\n").is_err());
    }

    #[test]
    fn faults_name_line_and_column() {
        let e = parse("a.csv", b"x_mm,y_mm,z_mm\n1,2,3\n1,NaN,3\n").unwrap_err();
        assert!(e.message.contains("line 3") && e.message.contains("y_mm"), "{e}");
        assert!(parse("a.csv", b"x,y\n1,2\n").unwrap_err().message.contains("x_mm"));
        assert!(parse("a.csv", b"").is_err());
    }
}
