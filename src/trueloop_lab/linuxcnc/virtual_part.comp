component virtual_part "A turned part that a touch probe meets: the probe input closes where ball and surface touch.";
description """
The surface is a polyline in the (x, z) plane, x a radius, read once from `surface.bin` in the
folder that LinuxCNC was started in: doubles in native order, the number of points, ball radius, pre-travel, lobing,
lobes, lobing phase, then x and z of every point; mm and rad.
""";
pin in float x "X of the ball's centre, radius, mm";
pin in float z "Z of the ball's centre, mm";
pin out bit contact "the probe has tripped";
pin out float distance "from the ball's centre to the surface, mm";
function _ fp;
option extra_setup yes;
license "GPL";
;;
#include <stdio.h>
#include <stdlib.h>
#include <rtapi_math.h>

enum { HEAD = 6 };
static double head[HEAD];
static double *points;
static long point_count;

static int read_surface(void) {
    FILE *file = fopen("surface.bin", "rb");
    if (!file) return -ENOENT;
    int good = fread(head, sizeof(double), HEAD, file) == HEAD && head[0] >= 2;
    if (good) {
        point_count = (long)head[0];
        points = malloc(2 * point_count * sizeof(double));
        good = points && fread(points, 2 * sizeof(double), point_count, file) == (size_t)point_count;
    }
    fclose(file);
    return good ? 0 : -EINVAL;
}

EXTRA_SETUP() { return read_surface(); }

FUNCTION(_) {
    double best = 1e300, dx = 0, dz = 0;
    for (long k = 0; k + 1 < point_count; k++) {
        const double *a = points + 2 * k, *b = a + 2;
        double ux = b[0] - a[0], uz = b[1] - a[1], px = x - a[0], pz = z - a[1];
        double length = ux * ux + uz * uz, share = length > 0 ? (px * ux + pz * uz) / length : 0;
        share = share < 0 ? 0 : share > 1 ? 1 : share;
        double ex = px - share * ux, ez = pz - share * uz, square = ex * ex + ez * ez;
        if (square < best) { best = square; dx = ex; dz = ez; }
    }
    double trip = head[2] + head[3] * cos(head[4] * (atan2(dx, dz) - head[5]));
    distance = sqrt(best);
    contact = distance <= head[1] - trip;
}
