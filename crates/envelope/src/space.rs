//! Vectors in space.

/// A point or a vector: (x, y, z).
pub type Point3 = [f64; 3];

pub(crate) fn minus(a: Point3, b: Point3) -> Point3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot(a: Point3, b: Point3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn length(vector: Point3) -> f64 {
    dot(vector, vector).sqrt()
}

/// A point and so much of a vector.
pub(crate) fn along(point: Point3, share: f64, vector: Point3) -> Point3 {
    [0, 1, 2].map(|k| point[k] + share * vector[k])
}
