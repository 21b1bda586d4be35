//! The region a nose passes over, and where rays out of the material meet it.

use crate::nose::{Disc, Nose};
use crate::ray::{Point, Ray};
use crate::tree::{Tree, RUN};

/// A nose swept along a polyline of its centre.
#[derive(Clone, Debug)]
pub struct Sweep {
    nodes: Vec<Point>,
    /// Contact of each segment's two sides, from the centre: surface normal to the left of travel, and to the right.
    contacts: Vec<[Point; 2]>,
    nose: Nose,
    tree: Tree,
}

/// A ray, the disc that holds the nose as seen along it, and how far down it is looked.
struct Asked {
    ray: Ray,
    disc: Disc,
    floor: f64,
}

/// The lowest meeting so far, and the run of segments it was found in.
#[derive(Clone, Copy)]
struct Found {
    along: f64,
    run: usize,
}

impl Sweep {
    /// The sweep; one node is a nose that stands still, none sweeps nothing. Nodes must be finite numbers.
    pub fn new(nodes: Vec<Point>, nose: Nose) -> Self {
        let contacts = nodes
            .windows(2)
            .map(|pair| match *pair {
                [a, b] => contacts_of(a, b, &nose),
                _ => [[0.0; 2]; 2],
            })
            .collect();
        let tree = Tree::over(&nodes);
        Self {
            nodes,
            contacts,
            nose,
            tree,
        }
    }

    /// Where each ray, coming out of the material, first meets the swept region: between −reach and what is `known`.
    ///
    /// `known` where it meets nothing lower. A nose whose centre lies below −reach on the ray is not seen.
    pub fn entries(&self, rays: impl Iterator<Item = (Ray, f64)>, reach: f64) -> Vec<f64> {
        let mut run = 0;
        rays.map(|(ray, known)| {
            let asked = Asked {
                ray,
                disc: self.nose.disc(ray.angle),
                floor: -reach,
            };
            let found = self.entry(&asked, Found { along: known, run });
            run = found.run;
            found.along.max(-reach)
        })
        .collect()
    }

    /// Neighbouring rays meet neighbouring segments: looking first where the last one was met, then from there up the
    /// tree at what stands beside, leaves little to look at.
    fn entry(&self, asked: &Asked, mut found: Found) -> Found {
        let mut index = found.run;
        self.look_at(asked, index, &mut found);
        for level in 0..self.tree.top() {
            self.descend(asked, level, index ^ 1, &mut found);
            index /= 2;
        }
        found
    }

    /// Looks at the segments in a box, where it reaches below what was found.
    fn descend(&self, asked: &Asked, level: usize, index: usize, found: &mut Found) {
        if self.lowest(asked, level, index, found).is_none() {
            return;
        }
        if level == 0 {
            return self.look_at(asked, index, found);
        }
        let (a, b) = (2 * index, 2 * index + 1);
        let [low_a, low_b] = [a, b].map(|child| self.lowest(asked, level - 1, child, found));
        let better = low_b.is_some_and(|b| low_a.is_none_or(|a| b < a));
        for child in if better { [b, a] } else { [a, b] } {
            self.descend(asked, level - 1, child, found);
        }
    }

    fn lowest(&self, asked: &Asked, level: usize, index: usize, found: &Found) -> Option<f64> {
        let around = self.tree.get(level, index)?;
        around.lowest(&asked.ray, &asked.disc, asked.floor, found.along)
    }

    fn look_at(&self, asked: &Asked, run: usize, found: &mut Found) {
        let first = run * RUN;
        let nodes = self.nodes.get(first..).unwrap_or_default();
        let contacts = self.contacts.get(first..).unwrap_or_default();
        let mut before: Option<((f64, f64), &[Point; 2])> = None;
        let mut turn = 0.0;
        let ahead = contacts.iter().map(Some).chain(std::iter::repeat(None));
        for (node, after) in nodes.iter().zip(ahead).take(RUN + 1) {
            let here = asked.ray.of(*node);
            let mut meets = self.body(asked, here, found.along, &mut turn);
            if let Some((there, contacts)) = before {
                meets = meets.min(flat(asked, there, here, contacts));
            }
            if meets < found.along {
                *found = Found { along: meets, run };
            }
            before = after.map(|contacts| (here, contacts));
        }
    }

    /// Where the ray meets the nose standing at a node; infinite when not below `best`.
    fn body(&self, asked: &Asked, (along, over): (f64, f64), best: f64, turn: &mut f64) -> f64 {
        let disc = &asked.disc;
        let beside = over - disc.beside;
        let square = disc.radius * disc.radius - beside * beside;
        let above = along - disc.above - best;
        if along <= asked.floor || square <= 0.0 || (above > 0.0 && above * above >= square) {
            return f64::INFINITY;
        }
        self.nose
            .depth(asked.ray.angle, over, turn)
            .map_or(f64::INFINITY, |depth| along - depth)
    }
}

/// Where the ray meets the straight side between the contacts of a segment's two ends; infinite when it passes beside.
fn flat(asked: &Asked, a: (f64, f64), b: (f64, f64), contacts: &[Point; 2]) -> f64 {
    let ray = &asked.ray;
    // Of the two sides the one whose normal looks along the ray: travel to greater `across` has it on its right.
    let [left, right] = contacts;
    let contact = if a.1 < b.1 { right } else { left };
    let (along, over) = (ray.along(*contact), ray.over(*contact));
    let (from, to) = (a.1 + over, b.1 + over);
    if (from > 0.0) == (to > 0.0) || from == to {
        return f64::INFINITY;
    }
    let share = from / (from - to);
    let centre = a.0 + share * (b.0 - a.0);
    if centre <= asked.floor {
        return f64::INFINITY;
    }
    centre + along
}

fn contacts_of(a: Point, b: Point, nose: &Nose) -> [Point; 2] {
    let (dx, dz) = (b[0] - a[0], b[1] - a[1]);
    let length = dx.hypot(dz);
    if length <= 0.0 {
        return [[0.0; 2]; 2];
    }
    let left = [dz / length, -dx / length];
    [nose.contact(left), nose.contact([-left[0], -left[1]])]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn round(radius: f64) -> Nose {
        Nose::new(radius, 0.0, 1.0, Vec::new()).expect("round")
    }

    #[test]
    fn a_straight_cut_leaves_a_straight_line() {
        for nodes in [
            vec![[10.8, 0.0], [10.8, 50.0]],
            vec![[10.8, 50.0], [10.8, 0.0]],
        ] {
            let sweep = Sweep::new(nodes, round(0.8));
            let rays = (1..40).map(|k| (Ray::new([9.9, k as f64], [1.0, 0.0]), 1.0));
            for height in sweep.entries(rays, 1.0) {
                assert!((height - 0.1).abs() < 1e-12, "{height}");
            }
        }
    }

    #[test]
    fn beyond_the_end_the_nose_leaves_its_own_arc() {
        let sweep = Sweep::new(vec![[10.8, 0.0], [10.8, 50.0]], round(0.8));
        let height = sweep.entries(
            std::iter::once((Ray::new([10.0, 50.5], [1.0, 0.0]), 2.0)),
            2.0,
        );
        assert!((height[0] - (0.8 - (0.64_f64 - 0.25).sqrt())).abs() < 1e-12);
        let none = sweep.entries(
            std::iter::once((Ray::new([10.0, 60.0], [1.0, 0.0]), 2.0)),
            2.0,
        );
        assert_eq!(none, vec![2.0]);
    }

    #[test]
    fn nothing_swept_is_nothing_cut() {
        assert_eq!(
            Sweep::new(Vec::new(), round(0.8))
                .entries([(Ray::new([0.0; 2], [1.0, 0.0]), 1.0)].into_iter(), 1.0),
            vec![1.0]
        );
    }
}
