//! Edges between texels on a row of points.

/// Where a row of indices leaves what it has been, in the direction in which it goes on the whole. An
/// index that only flickers between two values crosses one edge, once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Edges {
    /// The point before each edge, and the index behind it, counted from the row's start.
    at: Vec<(usize, i64)>,
}

impl Edges {
    /// Of indices in a row; `first_point` is the first one's point.
    pub fn of(first_point: usize, indices: impl Iterator<Item = i64> + Clone) -> Self {
        let Some(start) = indices.clone().next() else { return Self::default() };
        let side = (indices.clone().last().unwrap_or(start) - start).signum();
        let mut farthest = 0;
        let mut at = vec![];
        for (point, index) in indices.enumerate() {
            let place = (index - start) * side;
            if place > farthest {
                farthest = place;
                at.push((first_point + point - 1, place));
            }
        }
        Self { at }
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.at.len()
    }

    /// The points of the first and the last edge; `None` for fewer than two edges.
    pub fn span(&self) -> Option<[usize; 2]> {
        let (&(first, _), &(last, _)) = (self.at.first()?, self.at.last()?);
        (last > first).then_some([first, last])
    }

    /// Texels between two points: along straight lines from edge to edge, the first and the last of which
    /// go on. 0 for fewer than two edges.
    pub fn texels_between(&self, points: [usize; 2]) -> f64 {
        let [from, to] = points.map(|point| self.texels_at(point as f64));
        to - from
    }

    fn texels_at(&self, point: f64) -> f64 {
        let behind = self.at.partition_point(|&(edge, _)| edge as f64 <= point);
        let last_pair = self.at.len().saturating_sub(2);
        match self.at[behind.saturating_sub(1).min(last_pair)..] {
            [(from, low), (to, high), ..] => {
                low as f64 + (point - from as f64) * (high - low) as f64 / (to - from) as f64
            }
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(first_point: usize, indices: &[i64]) -> Edges {
        Edges::of(first_point, indices.iter().copied())
    }

    #[test]
    fn edges_lie_between_points() {
        let edges = of(10, &[7, 7, 8, 8, 8, 9, 11, 11]);
        assert_eq!(edges.at, [(11, 1), (14, 2), (15, 4)]);
        assert_eq!((edges.count(), edges.span()), (3, Some([11, 15])));
    }

    #[test]
    fn an_index_that_flickers_crosses_an_edge_once() {
        assert_eq!(of(10, &[0, 0, 1, 0, 1, 1, 2, 1, 2, 3]).at, [(11, 1), (15, 2), (18, 3)]);
        assert_eq!(of(0, &[5, 4, 5, 4, 5]), Edges::default());
        assert_eq!(of(0, &[5, 6, 5, 6]).span(), None);
    }

    #[test]
    fn falling_indices_count_as_rising_ones() {
        assert_eq!(of(0, &[0, -1, 0, -2]).at, [(0, 1), (2, 2)]);
    }

    #[test]
    fn texels_go_on_between_and_beyond_the_edges() {
        // Edges behind the points 11, 14 and 15, two texels from the second to the third.
        let edges = of(10, &[7, 7, 8, 8, 8, 9, 11, 11]);
        for (points, texels) in
            [([11, 15], 3.0), ([11, 14], 1.0), ([8, 11], 1.0), ([14, 17], 6.0), ([12, 12], 0.0)]
        {
            assert!((edges.texels_between(points) - texels).abs() < 1e-12, "{points:?}");
        }
    }

    #[test]
    fn nothing_has_no_edges() {
        assert_eq!(of(3, &[1, 2]).texels_between([3, 8]), 0.0);
        assert_eq!(of(3, &[1, 2]).span(), None);
        assert_eq!((of(3, &[]), of(3, &[1])), (Edges::default(), Edges::default()));
    }
}
