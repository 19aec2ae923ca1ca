use super::analysis::*;
use crate::synthetic::*;

#[test]
fn print_all() {
    let mut settings = SyntheticSettings::preset("target-task").unwrap();
    let t0 = std::time::Instant::now();
    let (recording, truth) = SyntheticEye::new(settings.clone(), 1).unwrap().record(1200_000_000_000, 1000.0).unwrap();
    println!("took {:?} for {} events {}", t0.elapsed(), recording.len(), truth.events.len());
    let mut traces = vec![("synth", Trace::measured(&recording))];
    settings.scene.half_width_deg = 25.0;
    let (recording, _) = SyntheticEye::new(settings.clone(), 2).unwrap().record(1200_000_000_000, 1000.0).unwrap();
    traces.push(("wide", Trace::measured(&recording)));
    if let Some(t) = Trace::hand_labelled() { traces.push(("irf", t)); }
    for (name, t) in &traces {
        println!("== {name} rms {:.4}", t.rms_s2s_deg());
        let s = t.saccades();
        let (b, a) = line(s.iter().filter(|s| s.amplitude_deg > 0.5).map(|s| (s.amplitude_deg, s.duration_ms)));
        println!("D = {b:.3} A + {a:.2}; n {} ({:.2}/s)", s.len(), s.len() as f64 / (t.label.len() as f64 / 1000.0));
        for at in [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0f64] {
            let r: Vec<_> = s.iter().filter(|s| (s.amplitude_deg / at).ln().abs() < 0.15).collect();
            if r.is_empty() { continue; }
            let p = percentile(&r.iter().map(|s| s.peak_deg_s * (1.0 - (-at / 8.9).exp()) / (1.0 - (-s.amplitude_deg / 8.9).exp())).collect::<Vec<_>>(), 0.5);
            let d = percentile(&r.iter().map(|s| s.duration_ms - 2.28 * (s.amplitude_deg - at)).collect::<Vec<_>>(), 0.5);
            println!("  {at} n {} D {d:.1} ({:.1}) P {p:.0} ({:.0})", r.len(), 2.28 * at + 14.6, 564.0 * (1.0 - (-at / 8.9).exp()));
        }
        for (lo, hi) in [(10., 25.), (25., 40.), (40., 60.), (60., 80.), (80., 150.)] {
            let r: Vec<_> = s.iter().filter(|s| s.duration_ms >= lo && s.duration_ms < hi).map(|s| s.peak_at).collect();
            if r.is_empty() { continue; }
            println!("  skew {lo}-{hi} n {} {:.3}", r.len(), percentile(&r, 0.5));
        }
        let i = t.intervals_ms();
        println!("isi {:?}", [0.1, 0.25, 0.5, 0.75, 0.9].map(|f| percentile(&i, f)));
        println!("amp {:?}", [0.1, 0.25, 0.5, 0.75, 0.9].map(|f| (percentile(&s.iter().map(|s| s.amplitude_deg).collect::<Vec<_>>(), f)*100.).round()/100.));
        let o = t.lengths(OSCILLATION);
        println!("pso {} {:?}", o.len(), [0.1, 0.5, 0.9].map(|f| percentile(&o, f)));
        let f = t.lengths(FIXATION);
        println!("fix {:?} blink {:?}", [0.1, 0.5, 0.9].map(|p| percentile(&f, p)), t.lengths(5).len());
        let v = t.speed_deg_s();
        let v: Vec<f64> = v.iter().zip(&t.label).filter(|(v, l)| **l == 1 && v.is_finite()).map(|(v, _)| *v).collect();
        println!("vel {:.2} {:.2}", percentile(&v, 0.5), percentile(&v, 0.95));
        for lag in [1usize, 2, 4, 8, 10, 20, 50, 100] {
            let mut q = vec![];
            for r in t.runs().iter().filter(|r| r.label == 1 && r.to - r.from > 150) {
                let p = &t.place_deg[r.from..r.to];
                let m: f64 = (0..p.len() - lag).map(|i| p[i].distance_squared(p[i + lag])).sum::<f64>() / (p.len() - lag) as f64;
                if m.is_finite() { q.push(m.sqrt()); }
            }
            print!(" lag {lag} {:.4}", percentile(&q, 0.5));
        }
        println!();
    }
}
