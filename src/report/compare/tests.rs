use super::*;
use crate::optics::Index;
use crate::report::page::html::escape;

fn root(id: i64, parent: i64, to: [f64; 3]) -> Root {
    let at = |k: usize| to.map(|x| x * k as f64 / 40.0);
    Root { id, parent, order: u32::from(parent >= 0), points_mm: (0..=40).map(at).collect(), radii_mm: vec![0.5; 41] }
}

fn shown(name: &str, roots: Vec<Root>, length: f64, high: &str) -> Shown {
    let tank = Tank {
        radius_mm: 40.0,
        height_mm: 120.0,
        wall_mm: 3.0,
        water_level_mm: 10.0,
        index: Index::default(),
        belts_mm: vec![],
    };
    let traits = vec![Trait { name: "total_root_length_mm".into(), value: length }];
    let settings = [("extract.high", high), ("extract.low", "0.7")];
    let settings = settings.map(|(name, value)| (name.to_owned(), value.to_owned())).into();
    Shown { name: name.into(), about: "a < b".into(), tank, roots, traits, settings }
}

fn three() -> [Shown; 3] {
    let taproot = || root(0, -1, [0.0, 0.0, 90.0]);
    [
        shown("</script>", vec![taproot(), root(1, 0, [30.0, 0.0, 20.0])], 126.0, "1.1"),
        shown("same", vec![taproot(), root(1, 0, [30.0, 0.0, 20.0])], 126.0, "1.1"),
        shown("other", vec![root(4, -1, [0.0, 0.0, 60.0]), root(5, -1, [0.0, 30.0, 20.0])], 96.0, "2.0"),
    ]
}

#[test]
fn the_page_tells_what_differs_and_asks_for_nothing() {
    let shown = three();
    let page = Page::new("a plant", &shown);
    let html = page.html().unwrap();
    assert_eq!(html, Page::new("a plant", &shown).html().unwrap());
    let body = &html[html.find("<body>").unwrap()..html.find("id=\"data\"").unwrap()];
    assert!(body.contains("No root differs.") && body.contains("in A only") && body.contains("in C only"));
    assert_eq!(body.matches("data-fate=\"length\"").count(), 1);
    // −30 mm are −24 % of A's 126 mm.
    assert!(body.contains(">−30</td><td class=\"n\">−24</td>"), "{body}");
    assert!(body.contains("extract.high") && !body.contains("extract.low"));
    assert!(
        html.contains("connect-src 'none'") && !body.contains("</script>\n<") && body.contains(&escape("</script>"))
    );
    assert_eq!(body.matches("role=\"application\"").count(), 3);
}

#[test]
fn the_first_is_coloured_by_its_greatest_difference() {
    let shown = three();
    let page = Page::new("a plant", &shown);
    use crate::growth::same_roots::Fate;
    let all = fates::of_all(&page);
    assert_eq!(all, [[Fate::Length, Fate::Only], [Fate::Same, Fate::Same], [Fate::Length, Fate::Only]]);
    assert!(fates::ALL.iter().enumerate().all(|(n, (fate, ..))| *fate as usize == n));
    assert_eq!(page.strangers().count(), 0);
    assert!(page.told().nth(1).unwrap().contains("1 in A only, 1 in C only"), "{:?}", page.told().nth(1));
}
