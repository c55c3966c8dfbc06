//! TEMPORARY
use super::pictures::*;
use super::*;
#[test]
#[ignore]
fn look() {
    let trace = synthetic::mission();
    let dir = std::path::Path::new("/tmp/look");
    let summary = serde_json::json!({"scenario": trace.scenario, "seed": 42, "version":"0.1.0", "success": true,
      "relays_used": 3, "length_m": 34.12, "mean_link_gap_db": 1.234, "nested": {"outage_s": 0.0, "min_rssi_dbm": -71.2, "list":[1,2,3.5], "none": null}});
    println!("{:?}", write_all(dir, &trace, &summary).unwrap());
    let mut n = 1u32;
    let mut vals = |c: f32, s: f32, never: usize| -> Vec<f32> {
        (0..60)
            .map(|i| {
                n = n.wrapping_mul(1664525).wrapping_add(1013904223);
                if i < never {
                    f32::INFINITY
                } else {
                    (c + s * ((n >> 8) as f32 / 8388608.0 - 1.0) * ((n >> 4) % 7) as f32 / 3.0)
                        .max(0.1)
                }
            })
            .collect()
    };
    let mut chart = |title: &str, v: &str, c: f32, s: f32| BoxChart {
        title: title.into(),
        value_name: v.into(),
        infinite_name: "never".into(),
        groups: ["S-turn", "U-turn", "Wave"]
            .iter()
            .enumerate()
            .map(|(g, l)| BoxGroup {
                label: (*l).into(),
                series: ["T0", "T5", "K"]
                    .iter()
                    .enumerate()
                    .map(|(i, n)| BoxPlotData {
                        name: (*n).into(),
                        values: vals(
                            c * (1.0 + 0.2 * g as f32 + 0.3 * i as f32),
                            s,
                            if i == 1 { 3 * g } else { 0 },
                        ),
                    })
                    .collect(),
            })
            .collect(),
    };
    let e = chart("Convergence", "Time until links are equal, s", 15.0, 8.0);
    let f = chart("Steadiness", "Variance of positions, m²", 0.05, 0.03);
    let p = box_plots(&e).unwrap();
    std::fs::write(dir.join("boxes.svg"), p.svg()).unwrap();
    std::fs::write(dir.join("boxes.png"), p.png().unwrap()).unwrap();
    let fig = Figure3 {
        title: "U-Chain in simulation",
        subtitle: "Three corridors, one exploration, 60 runs each",
        corridors: ["Corridor 1", "Corridor 2", "Corridor 3"]
            .iter()
            .map(|n| Corridor { name: n, trace: &trace })
            .collect(),
        exploration: ["T0", "T5", "K"].iter().map(|n| Variant { name: n, trace: &trace }).collect(),
        convergence: e,
        variance: f,
    };
    let p = figure3(&fig).unwrap();
    std::fs::write(dir.join("figure3.svg"), p.svg()).unwrap();
    std::fs::write(dir.join("figure3.png"), p.png().unwrap()).unwrap();
}
