component rtec "Real-time error correction: what a machine model and a table say is added between motion and the drives.";
description """
The component stands between motion and the drives. *rtec.write* adds the correction of this period to the commands,
*rtec.read* takes the correction of the same output out of the feedback: motion, its following error and its display see a
machine without it. Order in the servo thread:

    rtec.read, motion-command-handler, motion-controller, rtec.write, the functions of the drives

Positions are in the machine's unit, as motion's are, and latch-N is in machine coordinates; corrections, limits and
slew are in mm and mm/s on every machine, and *mm-per-unit* says how many mm its unit has. N is 0, 1, 2 for X, Y, Z.

The image is a file that *trueloop realtime image* writes. A file that is none, or is not for this machine, is refused
by name, and *loadrt* fails. At each rising edge of *reload* the file is read again, by an ordinary thread, beside the image in
force, which is exchanged only while *enable* is off and nothing is added.
""";
examples """
    loadrt rtec image=lathe.rtec serial=4711
    addf rtec.read servo-thread

*trueloop realtime hal lathe.ini* prints all lines that a configuration needs.
""";
see_also """*trueloop realtime*, docs/realtime-component.md""";
pin in float at-#[3] "Where the correction is asked for: joint.N.pos-cmd (motor-pos-cmd holds the homing offset)";
pin in float cmd-#[3] "What motion commands: joint.N.motor-pos-cmd";
pin out float out-#[3] "To the drive: cmd-N and the correction";
pin in float drive-fb-#[3] "What the drive measures";
pin out float fb-#[3] "To joint.N.motor-pos-fb: drive-fb-N without the correction";
pin in float tool-#[3] "Tool offset in force: motion.tooloffset.x, y, z";
pin in float signal-#[16] "Signals in the order of the image";
pin in float age-#[16] "How long ago each was read, s";
pin in unsigned heartbeat "Changes with every message of the signals' component; until it has changed once, signals count as silent";
pin in signed line "motion.program-line";
pin in signed program "0: no program runs; 1: that of the image's table; 2: another";
pin in signed motion-type "motion.motion-type; 5 is probing";
pin in bit enable "Whether the correction shall be in force; taking it away clears a fault";
pin in bit homed "All joints are homed and none is homing; without it the correction goes to zero";
pin in bit machine-on "motion.motion-enabled; without it the correction goes to zero";
pin in bit probing "A probing session is going on";
pin in bit touch "motion.probe-input: its rising edge latches";
pin in bit reload "Rising edge: read the image again";
pin out float corr-#[3] "Correction in force, mm";
pin out float model-#[3] "What the model asks for, mm";
pin out float table-#[3] "What the table asks for, mm";
pin out float latch-#[3] "Where the tool was at the last touch, machine coordinates, the machine's errors taken into account";
pin out float in-use-#[16] "Signals that the model is asked with";
pin out float oldest-age "Age of the oldest signal in use, s";
pin out signed phase "0 off, 1 waiting, 2 ramping, 3 in force, 4 frozen, 5 leaving, 6 faulted";
pin out bit fault "Stays until enable goes off";
pin out signed fault-code "0 none, 1 limit, 2 not a number, 3 travel, 4 stale, 5 range, 6 jump, 7 watchdog, 8 program, 9 off path, 10 settings";
pin out signed fault-signal "Signal that a fault is about, without a fault the first bad one; -1: none, or all of them";
pin out signed waits-for "What phase waiting waits for: 0 nothing, 1 homing, 2 drives, 3 probing, 4 signals";
pin out signed signal-fault "What is wrong with the first bad signal, as fault-code says it, in any phase; 0: nothing";
pin out bit enabled "The correction is in force";
pin out bit active "Something is added";
pin out bit on-path "The table has a row for this place";
pin out bit pause "To halui.program.pause";
pin out signed reload-error "Why the last image was refused: 0 none, 1 missing, 2 empty, 3 short, 4 odd, 5 long, 6 magic, 7 version, 8 hash, 9 serial, 10 count, 11 not finite, 12 program, 13 order, 14 body, 15 limits";
pin out unsigned generation = 1 "Images that were in force, this one included";
pin out unsigned periods "How often rtec.write ran";
pin out unsigned signals "How many signals the image needs";
param rw float limit = 0.150 "Largest correction of an axis, mm; the image's own holds where it is smaller";
param rw float slew = 5.0 "How fast the correction may change, mm/s: a backlash of 0.02 mm takes 4 ms";
param rw float resolution = 0 "Smallest step of the correction, mm; 0: none";
param rw float stale = 10 "A reading older than this is bad, s";
param rw float freeze = 30 "How long the last good reading stands in for a bad one, s";
param rw float leave = 5 "How long the correction then takes to zero, s";
param rw float watchdog = 2 "Without a new heartbeat for this long every signal is bad, s";
param rw float off-path = 0.1 "How long a block of the table may be cut off its path, s";
param rw unsigned parts = 3 "1 the model, 2 the table, 3 both";
param rw bit probe-corrected = 0 "Leave the correction in force while probing";
param rw bit pause-program = 1 "Pause the program at a fault, and on the way to it";
param rw float mm-per-unit = 1 "25.4 on a machine in inches; a new value holds from when nothing is added";
function read "Feedback of the drives to motion: before motion-command-handler";
function write "Commands of motion to the drives: after motion-controller";
option no_convenience_defines yes;
option singleton yes;
option extra_setup yes;
option extra_cleanup yes;
include "rtec.h";
author "the authors of trueloop";
license "GPL";
;;
/* SPDX-License-Identifier: GPL-2.0-or-later
 *
 * It runs inside LinuxCNC's real-time process and uses its HAL: hence its licence. What decides is in the static library
 * behind rtec.h, MIT OR Apache-2.0, taken here under MIT. This file copies pins, reads files, and keeps a thread for that.
 * The functions are called `read` and `write`, as HAL shall show them: <unistd.h> cannot be included.
 */
#include <errno.h>
#include <limits.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <rtapi_math.h>
#define FUNCTION(name) static void name(struct __comp_state *hal, long period) /* halcompile looks for this word */

static char *image, *serial, *program;
RTAPI_MP_STRING(image, "file of the image");
RTAPI_MP_STRING(serial, "serial of this machine: an image of another one is refused");
RTAPI_MP_STRING(program, "the program that shall run: an image for another one is refused");

enum { MISSING = 1, TOO_LONG = 5 }; /* the refusals that come before an image is looked at */
enum { PAGE = 4096, MOST_BYTES = 64 << 20, STACK_BYTES = 1 << 20, LOOK_NS = 10000000 };

typedef struct { unsigned char *bytes; long count; } content;

/* Two places for an image: one in force, one to load into. `hand` says in one word which is which: bit 0 is the place in
 * force, bit 1 says that the other one holds a checked image.
 *
 * The servo thread reads the place in force and nothing else. The loader writes the other, and only while bit 1 is off: it
 * takes the bit back by compare-and-exchange before it loads anew. The servo thread takes the offer by one
 * compare-and-exchange that changes both bits at once: neither side ever sees one changed without the other. Its acquire
 * pairs with the loader's release: the image is whole when it is seen. The loader's acquire pairs with the servo
 * thread's release: it has left the old place before the loader sees it free. Nobody waits: what fails is tried again in
 * the next period. */
enum { IN_FORCE = 1, OFFERED = 2 };
static struct { content file; rtec_image *image; } place[2];
static unsigned hand;
static unsigned asked; /* rising edges of `reload` */
static int leaving;
static pthread_t loader;

/* Of the servo thread alone. */
static rtec_state *state;
static rtec_outputs said;
static double scale = 1; /* mm per unit */
static int was_reload;

/* Zeroed, and held in memory: a page fault would cost the servo thread its period. What may not be locked has at least
 * been touched. Whole pages, so that nothing else is on them. */
static void *held(size_t size) {
    size_t whole = (size / PAGE + 1) * PAGE;
    void *memory = aligned_alloc(PAGE, whole);
    if (!memory) return NULL;
    memset(memory, 0, whole);
    mlock(memory, whole);
    return memory;
}

/* The content of a file; 0, or the number of a refusal. */
static int read_file(const char *name, content *into) {
    FILE *file = fopen(name, "rb");
    if (!file) return MISSING;
    int refusal = MISSING;
    long count = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    if (count > MOST_BYTES && count != LONG_MAX) refusal = TOO_LONG; /* LONG_MAX is the length of a folder */
    else if (count >= 0 && count != LONG_MAX && (into->bytes = held(count))) {
        rewind(file);
        into->count = fread(into->bytes, 1, count, file);
        if (!ferror(file)) refusal = 0;
    }
    fclose(file);
    return refusal;
}

static void forget(content *file) {
    free(file->bytes);
    *file = (content){NULL, 0};
}

static int refused(const char *name, int refusal) {
    if (refusal) rtapi_print_msg(RTAPI_MSG_ERR, "rtec: %s: %s\n", name, rtec_refusal(refusal));
    return refusal;
}

/* Reads the image into a place; 0, or the number of a refusal, which has been said. */
static int load(int into) {
    content running = {NULL, 0}, *file = &place[into].file;
    forget(file);
    int refusal = refused(image, read_file(image, file));
    if (!refusal && program) refusal = refused(program, read_file(program, &running));
    if (!refusal)
        refusal = refused(image, rtec_image_init(place[into].image, file->bytes, file->count, serial, running.bytes, running.count));
    forget(&running);
    return refusal;
}

/* Takes back what was offered and not yet taken; the place in force. */
static unsigned withdrawn(void) {
    unsigned was = __atomic_load_n(&hand, __ATOMIC_ACQUIRE);
    while ((was & OFFERED)
           && !__atomic_compare_exchange_n(&hand, &was, was & IN_FORCE, 0, __ATOMIC_ACQ_REL, __ATOMIC_ACQUIRE)) {}
    return was & IN_FORCE;
}

/* The loader: an ordinary thread beside the servo thread. Pins exist once somebody has asked. */
static void *loading(void *of) {
    struct __comp_state *hal = of;
    unsigned done = 0;
    while (!__atomic_load_n(&leaving, __ATOMIC_ACQUIRE)) {
        nanosleep(&(struct timespec){0, LOOK_NS}, NULL);
        unsigned now = __atomic_load_n(&asked, __ATOMIC_ACQUIRE);
        if (now == done) continue;
        done = now;
        unsigned used = withdrawn();
        int refusal = load(!used);
        if (!refusal) __atomic_store_n(&hand, used | OFFERED, __ATOMIC_RELEASE);
        *hal->reload_error = refusal;
    }
    return NULL;
}

/* Not with the scheduling of whoever calls, which may be that of a real-time thread. */
static int start_loader(struct __comp_state *hal) {
    struct sched_param lowest = {0};
    pthread_attr_t ordinary;
    pthread_attr_init(&ordinary);
    pthread_attr_setinheritsched(&ordinary, PTHREAD_EXPLICIT_SCHED);
    pthread_attr_setschedpolicy(&ordinary, SCHED_OTHER);
    pthread_attr_setschedparam(&ordinary, &lowest);
    pthread_attr_setstacksize(&ordinary, STACK_BYTES);
    int failed = pthread_create(&loader, &ordinary, loading, hal);
    pthread_attr_destroy(&ordinary);
    return failed;
}

/* A failure here ends `loadrt`; extra_cleanup is called all the same. */
static int extra_setup(struct __comp_state *hal, char *prefix, long extra_arg) {
    (void)prefix;
    (void)extra_arg;
    if (!image) {
        rtapi_print_msg(RTAPI_MSG_ERR, "rtec: image: no file is named: loadrt rtec image=FILE\n");
        return -EINVAL;
    }
    for (int k = 0; k < 2; k++) place[k].image = held(rtec_image_size());
    state = held(rtec_state_size());
    if (!place[0].image || !place[1].image || !state) return -ENOMEM;
    if (load(0)) return -EINVAL;
    rtec_state_init(state);
    return -start_loader(hal);
}

static void extra_cleanup(void) {
    __atomic_store_n(&leaving, 1, __ATOMIC_RELEASE);
    if (loader) pthread_join(loader, NULL);
    for (int k = 0; k < 2; k++) {
        forget(&place[k].file);
        free(place[k].image);
    }
    free(state);
}

/* The image in force; first takes an offered one, where nothing is asked for and nothing is added. */
static rtec_image *in_force(struct __comp_state *hal) {
    unsigned was = __atomic_load_n(&hand, __ATOMIC_ACQUIRE), next = !(was & IN_FORCE);
    int may = (was & OFFERED) && !*hal->enable && !said.active;
    if (may && __atomic_compare_exchange_n(&hand, &was, next, 0, __ATOMIC_ACQ_REL, __ATOMIC_ACQUIRE)) {
        ++*hal->generation;
        was = next;
    }
    return place[was & IN_FORCE].image;
}

/* Of signals those alone that the image needs: each pin is a place of its own in memory. */
static rtec_inputs inputs(struct __comp_state *hal, long period, unsigned signals) {
    double mm = hal->mm_per_unit;
    int usable = mm > 0 && mm < 1e6; /* false for what is not a number */
    if (usable && !said.active) scale = mm;
    rtec_inputs in = {
        .period_s = period * 1e-9,
        .heartbeat = *hal->heartbeat,
        .line = *hal->line,
        .program = *hal->program,
        .motion_type = *hal->motion_type,
        .enable = *hal->enable,
        .homed = *hal->homed,
        .machine_on = *hal->machine_on,
        .probing = *hal->probing,
        .touch = *hal->touch,
    };
    for (int k = 0; k < RTEC_AXES; k++) {
        in.position[k] = usable ? *hal->at[k] * scale : NAN; /* which the corrector refuses */
        in.tool_offset[k] = *hal->tool[k] * scale;
    }
    for (unsigned k = 0; k < signals; k++) {
        in.signal[k] = *hal->signal[k];
        in.age_s[k] = *hal->age[k];
    }
    return in;
}

static rtec_settings settings(const struct __comp_state *hal) {
    return (rtec_settings){
        .limit_mm = hal->limit,
        .slew_mm_per_s = hal->slew,
        .resolution_mm = hal->resolution,
        .stale_s = hal->stale,
        .freeze_s = hal->freeze,
        .leave_s = hal->leave,
        .watchdog_s = hal->watchdog,
        .off_path_s = hal->off_path,
        .parts = hal->parts,
        .probe_corrected = hal->probe_corrected,
        .pause_program = hal->pause_program,
    };
}

/* What the pins say. Each pin is a cache line of its own, which a period finds cold: what keeps its value is left alone. */
static rtec_outputs shown;
static int shown_fault;
static unsigned shown_signals;
#define SHOW(pin, before, now) do { if ((before) != (now)) *(pin) = (before) = (now); } while (0)

static void show(struct __comp_state *hal, const rtec_outputs *out, unsigned signals) {
    for (int k = 0; k < RTEC_AXES; k++) {
        SHOW(hal->corr[k], shown.correction[k], out->correction[k]);
        SHOW(hal->model[k], shown.model[k], out->model[k]);
        SHOW(hal->table[k], shown.table[k], out->table[k]);
        SHOW(hal->latch[k], shown.latch[k], out->latch[k] / scale);
    }
    for (int k = 0; k < RTEC_SIGNALS; k++) /* those of an image before that needed more go back to 0 */
        SHOW(hal->in_use[k], shown.in_use[k], k < (int)signals ? out->in_use[k] : 0.0);
    SHOW(hal->signals, shown_signals, signals);
    SHOW(hal->oldest_age, shown.oldest_age_s, out->oldest_age_s);
    SHOW(hal->phase, shown.phase, out->phase);
    SHOW(hal->fault, shown_fault, out->fault != 0);
    SHOW(hal->fault_code, shown.fault, out->fault);
    SHOW(hal->fault_signal, shown.fault_signal, out->fault_signal);
    SHOW(hal->waits_for, shown.waits_for, out->waits_for);
    SHOW(hal->signal_fault, shown.signal_fault, out->signal_fault);
    SHOW(hal->enabled, shown.enabled, out->enabled);
    SHOW(hal->active, shown.active, out->active);
    SHOW(hal->on_path, shown.on_path, out->on_path);
    SHOW(hal->pause, shown.pause, out->pause);
}

FUNCTION(read) {
    (void)period;
    for (int k = 0; k < RTEC_AXES; k++) *hal->fb[k] = *hal->drive_fb[k] - said.correction[k] / scale;
}

FUNCTION(write) {
    if (*hal->reload && !was_reload) __atomic_fetch_add(&asked, 1, __ATOMIC_RELEASE);
    was_reload = *hal->reload;
    rtec_image *asked_for = in_force(hal);
    unsigned signals = rtec_image_signals(asked_for);
    rtec_inputs in = inputs(hal, period, signals);
    rtec_settings set = settings(hal);
    rtec_step(asked_for, state, &in, &set, &said);
    for (int k = 0; k < RTEC_AXES; k++) *hal->out[k] = *hal->cmd[k] + said.correction[k] / scale;
    show(hal, &said, signals);
    ++*hal->periods;
}
