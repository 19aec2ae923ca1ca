//! Does foveation work with this latency? In words.

use super::summary::LatencySummary;
use serde::Serialize;

/// The conclusion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// `good` where the target is kept, `bad` where it is not, `open` where the session cannot tell.
    pub class: &'static str,
    /// In one line.
    pub headline: String,
    /// Why, and what to do.
    pub sentences: Vec<String>,
}

/// The conclusion from the figures of a run, as its page has it.
#[must_use]
pub fn verdict(summary: &LatencySummary) -> Verdict {
    let budget = &summary.budget;
    let radius_deg = budget.radius_deg;
    let Some(outside) = summary.outside_fraction else {
        return Verdict {
            class: "open",
            headline: "This session cannot tell whether foveation works".into(),
            sentences: vec![
                "There is no time in which the eye rests, sees, and has a gaze that is known: give the \
                 events, or a longer recording."
                    .into(),
            ],
        };
    };
    let (percent, target) = (outside * 100.0, budget.target_outside * 100.0);
    let works = outside <= budget.target_outside;
    let mut sentences = vec![format!(
        "While the eye rests and sees, the true gaze lies outside the {radius_deg}° of full quality for \
         {percent:.2} % of the time; {target} % are allowed."
    )];
    if let Some(all) = summary.outside_fraction_unsuppressed.filter(|all| *all > outside) {
        sentences.push(format!(
            "That counts on saccadic suppression: with the time just before and after saccades it is {:.2} %.",
            all * 100.0
        ));
    }
    let needed = budget.needed_radius_deg.unwrap_or(radius_deg);
    if works {
        sentences.push(format!("A radius of {needed:.2}° would still do."));
    } else {
        sentences.push(format!("It would need a radius of {needed:.2}°."));
    }
    sentences.push(match budget.largest_latency_ms {
        Some(largest) if budget.beyond_sweep => format!(
            "The gaze is {:.1} ms old on average; even {largest:.0} ms would do with this radius.",
            budget.latency_ms
        ),
        Some(largest) => format!(
            "The gaze is {:.1} ms old on average; with this radius it may be {largest:.1} ms old.",
            budget.latency_ms
        ),
        None => format!(
            "The gaze is {:.1} ms old on average; no latency is small enough for this radius: the tracker's \
             own error is larger.",
            budget.latency_ms
        ),
    });
    if let Some(stage) = budget.attack
        && let Some(share) = budget.stages.iter().find(|share| share.stage == stage)
    {
        sentences.push(format!(
            "Attack {} first ({:.1} ms): half of it would take {:.2}° off the radius.",
            stage.name().replace('_', " "),
            share.mean_ms,
            share.saved_if_half_deg
        ));
    }
    sentences.extend(summary.eye_to_photon_ms.map(against_published));
    Verdict {
        class: if works { "good" } else { "bad" },
        headline: if works {
            format!("Foveation works with this latency and a radius of {radius_deg}°")
        } else {
            format!("Foveation does not work with this latency and a radius of {radius_deg}°")
        },
        sentences,
    }
}

fn against_published(total_ms: f64) -> String {
    let place = if total_ms <= 50.0 {
        "below the"
    } else if total_ms <= 70.0 {
        "within the"
    } else {
        "above the"
    };
    format!(
        "From an eye movement to its first light it takes {total_ms:.1} ms on average, {place} 50 to 70 ms that \
         Albert et al. (2017) found tolerable."
    )
}
