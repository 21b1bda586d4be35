component recorder "Pins of every servo period, as doubles, in a file that can be read while it is written.";
description """
For runs that are judged to the nanometre, which six decimals of *halsampler* do not hold. The file is mapped into memory: use a
folder there. Its first double counts the rows, the second those that found no room; a row is the floats, then the
integers, unsigned ones and bits, as many as the module parameters say.
""";
pin in float f-#[40];
pin in signed s-#[16];
pin in unsigned u-#[8];
pin in bit b-#[16];
pin in bit enable;
function _;
option singleton yes;
option extra_setup yes;
option extra_cleanup yes;
license "GPL";
;;
/* SPDX-License-Identifier: GPL-2.0-or-later */
#include <errno.h>
#include <stdlib.h>
#include <stdio.h>
#include <sys/mman.h>

static char *file = "/tmp/recorder.bin";
static int floats, signeds, unsigneds, bits, depth = 60000;
RTAPI_MP_STRING(file, "where the rows go");
RTAPI_MP_INT(floats, "how many of f are recorded");
RTAPI_MP_INT(signeds, "how many of s");
RTAPI_MP_INT(unsigneds, "how many of u");
RTAPI_MP_INT(bits, "how many of b");
RTAPI_MP_INT(depth, "most rows");

enum { HEAD = 2 };
static double *rows;
static size_t size;

EXTRA_SETUP() {
    (void)__comp_inst; (void)prefix; (void)extra_arg;
    size = (HEAD + (size_t)depth * (floats + signeds + unsigneds + bits)) * sizeof(double);
    FILE *made = fopen(file, "wb");
    if (!made) return -EACCES;
    int failed = fseek(made, size - 1, SEEK_SET) != 0 || fputc(0, made) == EOF;
    failed |= fclose(made) != 0;
    made = fopen(file, "r+b");
    if (failed || !made) return -EIO;
    void *mapped = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, fileno(made), 0);
    fclose(made);
    if (mapped == MAP_FAILED) return -ENOMEM;
    rows = mapped;
    return 0;
}

EXTRA_CLEANUP() { if (rows) munmap(rows, size); }

FUNCTION(_) {
    if (!enable) return;
    if (rows[0] >= depth) { rows[1]++; return; }
    double *to = rows + HEAD + (size_t)rows[0] * (floats + signeds + unsigneds + bits);
    for (int k = 0; k < floats; k++) *to++ = f(k);
    for (int k = 0; k < signeds; k++) *to++ = s(k);
    for (int k = 0; k < unsigneds; k++) *to++ = u(k);
    for (int k = 0; k < bits; k++) *to++ = b(k);
    rows[0]++;
}
