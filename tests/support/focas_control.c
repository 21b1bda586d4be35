/* A stand-in for a Fanuc lathe and its FOCAS library: programs and offsets in memory, in this process.
 *
 * Written from the published declarations of the functions (a long has four bytes) and what users say of them, and not
 * from the code under test. A control takes a program piece by piece into a buffer of 256 bytes and says EW_BUFFER while
 * that is full; it names what is wrong with a program when the transfer ends. standin_fault chooses what goes wrong. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OK = 0, FUNC = 1, LENGTH = 2, NUMBER = 3, ATTRIB = 4, DATA = 5, OVRFLOW = 8, BUFFER = 10, REJECT = 13,
       BUSY = -1, HANDLE = -8, SOCKET = -16 };
enum { PROGRAMS = 40, ROOM = 60000, OFFSETS = 16, KINDS = 8 };

static struct { int32_t number; char *text; } memory[PROGRAMS];
static int32_t offsets[OFFSETS + 1][KINDS];
static char fault[32], coming[ROOM + 1], *going;
static int at, calls, room, started, filled, drained, sent, running, main_program, in_sub, writes, mill;
static unsigned short handle = 100;
static int open_handle;

static int is(const char *name) { return strcmp(fault, name) == 0; }

void standin_reset(int memory_bytes) {
    for (int k = 0; k < PROGRAMS; k++) { free(memory[k].text); memory[k].text = NULL; memory[k].number = 0; }
    memset(offsets, 0, sizeof offsets);
    fault[0] = 0; at = calls = started = running = writes = open_handle = mill = 0; room = memory_bytes;
}
void standin_fault(const char *name, int when) { snprintf(fault, sizeof fault, "%s", name); at = when; calls = writes = 0; }
int standin_calls(void) { return calls; }
void standin_runs(int state, int main_number, int sub_number) { running = state; main_program = main_number; in_sub = sub_number; }
void standin_mill(void) { mill = 1; }
void standin_offset(int number, int kind, int32_t value) { offsets[number][kind] = value; }
int32_t standin_offset_now(int number, int kind) { return offsets[number][kind]; }

static int find(int32_t number) {
    for (int k = 0; k < PROGRAMS; k++) if (memory[k].text && memory[k].number == number) return k;
    return -1;
}
static int used(void) {
    int total = 0;
    for (int k = 0; k < PROGRAMS; k++) if (memory[k].text) total += (int)strlen(memory[k].text);
    return total;
}
/* A program typed in at the control; text begins with O. */
int standin_type(int32_t number, const char *text) {
    int k = find(number);
    if (k < 0) for (k = 0; k < PROGRAMS && memory[k].text; k++) ;
    if (k == PROGRAMS) return 0;
    free(memory[k].text); memory[k].number = number; memory[k].text = strdup(text);
    return 1;
}
const char *standin_text(int32_t number) { int k = find(number); return k < 0 ? NULL : memory[k].text; }

/* Every call passes here: a handle that is not open, or that is lost from the at-th call on. */
static short entry(unsigned short h) {
    calls++;
    if (is("lost") && calls >= at) open_handle = 0;
    return open_handle && h == handle ? OK : HANDLE;
}
#define ENTER(h) do { short wrong = entry(h); if (wrong) return wrong; } while (0)

short cnc_startupprocess(int32_t level, const char *log) { return level == 0 && log && *log ? OK : FUNC; }
short cnc_allclibhndl3(const char *host, unsigned short port, int32_t timeout, unsigned short *h) {
    if (strcmp(host, "127.0.0.1") || port != 8193 || timeout < 1) return SOCKET;
    if (is("lost") && at <= 1 + calls++) return SOCKET;
    started = 0; open_handle = 1; *h = ++handle;
    return OK;
}
short cnc_freelibhndl(unsigned short h) { if (!open_handle || h != handle) return HANDLE; open_handle = 0; return OK; }

short cnc_sysinfo(unsigned short h, char *out) {
    ENTER(h);
    memcpy(out, "\0\0\40\0" "30" " T" "G421" "15.0" "02", 18);
    if (mill) out[7] = 'M';
    return OK;
}
short cnc_statinfo(unsigned short h, short *out) {
    ENTER(h);
    short state[9] = {0, 0, 1, (short)running, 0, 0, 0, 0, 0};
    memcpy(out, state, sizeof state);
    return OK;
}
short cnc_rdprgnum(unsigned short h, short *out) {
    ENTER(h);
    out[0] = out[1] = 0; out[2] = (short)(in_sub ? in_sub : main_program); out[3] = (short)main_program;
    return OK;
}

struct directory { int32_t number, length, page; char comment[52]; int16_t changed[6], made[6]; };
short cnc_rdprogdir3(unsigned short h, short type, int32_t *top, short *count, struct directory *rows) {
    ENTER(h);
    if (type < 0 || type > 2) return ATTRIB;
    int32_t last = *top - 1;
    short found = 0;
    while (found < *count) {
        int next = -1;
        for (int k = 0; k < PROGRAMS; k++)
            if (memory[k].text && memory[k].number > last && (next < 0 || memory[k].number < memory[next].number)) next = k;
        if (next < 0) break;
        last = rows[found].number = memory[next].number;
        rows[found].length = (int32_t)strlen(memory[next].text);
        found++;
    }
    *count = found;
    return OK;
}
short cnc_delete(unsigned short h, short number) {
    ENTER(h);
    int k = find(number);
    if (k < 0) return DATA;
    if (running && (number == main_program || number == in_sub)) return REJECT;
    free(memory[k].text); memory[k].text = NULL;
    return OK;
}

short cnc_dwnstart4(unsigned short h, short type, const char *folder) {
    ENTER(h);
    if (started) return BUSY;
    if (type != 0 || !folder) return ATTRIB;
    started = 'd'; filled = drained = 0;
    return OK;
}
short cnc_download4(unsigned short h, int32_t *length, const char *text) {
    ENTER(h);
    if (started != 'd') return FUNC;
    if (is("stalled")) { *length = 0; return BUFFER; }
    int free_now = 256 - (filled - drained);
    if (free_now <= 0) { drained = filled; *length = 0; return BUFFER; }
    int take = *length < free_now ? *length : free_now;
    if (take > 7) take -= calls % 7;
    if (filled + take > ROOM) return OVRFLOW;
    memcpy(coming + filled, text, (size_t)take);
    filled += take; *length = take;
    return OK;
}
short cnc_dwnend4(unsigned short h) {
    ENTER(h);
    if (started != 'd') return FUNC;
    started = 0; coming[filled] = 0;
    int number = 0;
    if (filled < 4 || coming[0] != '\n' || coming[filled - 1] != '%' || sscanf(coming + 1, "O%d", &number) != 1) return DATA;
    if (find(number) >= 0) return DATA;
    if (used() + filled > room) return OVRFLOW;
    coming[filled - 1] = 0;
    if (is("edits")) for (char *c = coming; *c; c++) if (*c == '5') *c = '6';
    return standin_type(number, coming + 1) ? OK : OVRFLOW;
}

short cnc_upstart4(unsigned short h, short type, const char *name) {
    ENTER(h);
    if (started) return BUSY;
    int k = type == 0 && name[0] == 'O' ? find(atoi(name + 1)) : -1;
    if (k < 0) return DATA;
    free(going); going = malloc(strlen(memory[k].text) + 8);
    sprintf(going, "%%\n%s%%", memory[k].text);
    started = 'u'; sent = 0;
    return OK;
}
short cnc_upload4(unsigned short h, int32_t *length, char *out) {
    ENTER(h);
    if (started != 'u') return FUNC;
    if (calls % 3 == 0) { *length = 0; return BUFFER; }
    int left = (int)strlen(going) - sent, give = sent == 0 ? 1 : 97; /* the first % comes alone */
    if (give > left) give = left;
    if (give > *length) give = *length;
    memcpy(out, going + sent, (size_t)give);
    sent += give; *length = give;
    return OK;
}
short cnc_upend4(unsigned short h) { ENTER(h); if (started != 'u') return FUNC; started = 0; return OK; }

short cnc_rdtofsinfo(unsigned short h, short *out) { ENTER(h); out[0] = 1; out[1] = OFFSETS; return OK; }
struct offset { int16_t number, kind; int32_t data; };
static short known(short number, short kind, short length) {
    if (length != 8) return LENGTH;
    if (number < 1 || number > OFFSETS) return NUMBER;
    return kind < 0 || kind >= KINDS ? ATTRIB : OK;
}
short cnc_rdtofs(unsigned short h, short number, short kind, short length, struct offset *out) {
    ENTER(h);
    short wrong = known(number, kind, length);
    if (wrong) return wrong;
    out->number = number; out->kind = kind; out->data = offsets[number][kind];
    return OK;
}
short cnc_wrtofs(unsigned short h, short number, short kind, short length, int32_t value) {
    ENTER(h);
    short wrong = known(number, kind, length);
    if (wrong) return wrong;
    if (++writes == at && is("range")) return DATA;
    offsets[number][kind] = is("rounds") ? value / 10 * 10 : value;
    return OK;
}
