#include "baroarma.h"

#include <math.h>
#include <stdio.h>

#ifndef BAROARMA_REPLAY

/* The self-test: golden vectors from Python, then samples that no sensor should give.
 *
 *     gcc *.c -lm -o selftest && ./selftest
 */

#include "baroarma_golden.h"

/* Say how it went; 1 if it failed. */
static int fails(int good, const char *what)
{
    printf("%s  %s\n", good ? "ok  " : "FAIL", what);
    return !good;
}

static int golden_failures(void)
{
    double worst[4] = {0, 0, 0, 0}, all = 0;
    int i, k, answers = 0;
    baroarma_state state;
    baroarma_init(&state);
    for (k = 0; k < BAROARMA_GOLDEN_ROWS; k++) {
        const baroarma_real *in = BAROARMA_GOLDEN_INPUT[k];
        const baroarma_result now = baroarma_step(&state, in, in + 3, in[6], BAROARMA_GOLDEN_DT);
        const double out[4]
            = {(double)now.height, (double)now.velocity, (double)now.height_sd, (double)now.velocity_sd};
        if (now.status != BAROARMA_OK || ++answers > BAROARMA_GOLDEN_ANSWERS) continue;
        for (i = 0; i < 4; i++) {
            const double off = fabs(out[i] - BAROARMA_GOLDEN_OUTPUT[answers - 1][i]);
            if (!(off <= worst[i])) worst[i] = off;
        }
    }
    for (i = 0; i < 4; i++) {
        if (!(worst[i] <= all)) all = worst[i];
    }
    printf("      off by at most %.2g m, %.2g m/s, sds %.2g m, %.2g m/s; allowed %.2g\n", worst[0], worst[1],
           worst[2], worst[3], BAROARMA_GOLDEN_TOLERANCE);
    return fails(answers == BAROARMA_GOLDEN_ANSWERS, "the alignment ends when it ends in Python")
        + fails(all <= BAROARMA_GOLDEN_TOLERANCE, "the golden vectors from Python");
}

static int all_finite(baroarma_result r)
{
    return isfinite(r.height) && isfinite(r.velocity) && isfinite(r.height_sd) && isfinite(r.velocity_sd)
        && isfinite(r.acceleration);
}

/* After a second of rest, feed the same sample for a while; whether the state stays finite. */
static int stays_finite(const baroarma_real accel[3], const baroarma_real gyro[3], baroarma_real pressure,
                        baroarma_real dt)
{
    const baroarma_real up[3] = {0, 0, 10}, still[3] = {0, 0, 0}, ground = 100000;
    int k, good = 1;
    baroarma_state state;
    baroarma_init(&state);
    for (k = 0; k < 300; k++) {
        good = good && all_finite(baroarma_step(&state, up, still, ground, BAROARMA_GOLDEN_DT));
    }
    for (k = 0; k < 300; k++) good = good && all_finite(baroarma_step(&state, accel, gyro, pressure, dt));
    for (k = 0; k < 300; k++) {
        good = good && all_finite(baroarma_step(&state, up, still, ground, BAROARMA_GOLDEN_DT));
    }
    return good;
}

static int strange_failures(void)
{
    const baroarma_real none = (baroarma_real)NAN, endless = (baroarma_real)INFINITY, dt = BAROARMA_GOLDEN_DT;
    const baroarma_real up[3] = {0, 0, 10}, still[3] = {0, 0, 0}, ground = 100000;
    const baroarma_real lost[3] = {none, none, none}, infinite[3] = {endless, -endless, endless};
    const baroarma_real force[3] = {314, -314, 314}, rate[3] = {70, -70, 70};
    return fails(stays_finite(up, still, none, dt), "no pressure")
        + fails(stays_finite(lost, still, ground, dt), "no accelerometer")
        + fails(stays_finite(up, lost, ground, dt), "no gyro")
        + fails(stays_finite(NULL, NULL, none, dt), "nothing at all")
        + fails(stays_finite(still, still, ground, dt), "free fall")
        + fails(stays_finite(up, still, ground, 0), "no time between samples")
        + fails(stays_finite(up, still, ground, none), "an interval that is no number")
        + fails(stays_finite(up, still, ground, -1), "time that goes back")
        + fails(stays_finite(up, still, ground, 3600), "an hour between samples")
        + fails(stays_finite(force, rate, ground, dt), "an IMU at its 32 g and 4000 degrees per second")
        + fails(stays_finite(infinite, infinite, endless, dt), "infinite samples")
        + fails(stays_finite(up, still, 0, dt) && stays_finite(up, still, -1, dt), "a dead barometer")
        + fails(stays_finite(up, still, 1, dt), "a barometer in a vacuum")
        + fails(stays_finite(up, still, 1000000, dt), "a barometer under water");
}

int main(void)
{
    const int failures = golden_failures() + strange_failures();
    printf("%d failed\n", failures);
    return failures > 0;
}

#else

/* The replay: a recording's CSV on stdin, its track's CSV on stdout, a row for each row.
 *
 *     gcc -DBAROARMA_REPLAY *.c -lm -o replay && ./replay < recording.csv > track.csv
 *
 * Columns by name, in any order, others left alone; an empty cell is no sample. */

#include <stdlib.h>
#include <string.h>

enum { TIME, PRESSURE, ACCEL, GYRO = ACCEL + 3, COLUMNS = GYRO + 3, MOST_CELLS = 64, LONGEST_LINE = 4096 };

static const char *const NAMES[COLUMNS] = {"time_s",     "pressure_pa",  "acc_x_m_s2",   "acc_y_m_s2",
                                           "acc_z_m_s2", "gyr_x_rad_s", "gyr_y_rad_s", "gyr_z_rad_s"};

/* Cut a line at its commas; how many cells there are. */
static int split(char *line, char *cells[MOST_CELLS])
{
    int n = 0;
    line[strcspn(line, "\r\n")] = '\0';
    while (n < MOST_CELLS) {
        cells[n++] = line;
        line = strchr(line, ',');
        if (line == NULL) break;
        *line++ = '\0';
    }
    return n;
}

static int find_columns(char *header, int column[COLUMNS])
{
    char *cells[MOST_CELLS];
    const int n = split(header, cells);
    int i, k;
    for (i = 0; i < COLUMNS; i++) {
        column[i] = -1;
        for (k = 0; k < n; k++) {
            if (strcmp(cells[k], NAMES[i]) == 0) column[i] = k;
        }
        if (column[i] < 0) {
            fprintf(stderr, "the recording has no column %s; write it with baroarma\n", NAMES[i]);
            return 0;
        }
    }
    return 1;
}

static void read_row(char *line, const int column[COLUMNS], double value[COLUMNS])
{
    char *cells[MOST_CELLS], *end;
    const int n = split(line, cells);
    int i;
    for (i = 0; i < COLUMNS; i++) {
        value[i] = (double)NAN;
        if (column[i] >= n) continue;
        value[i] = strtod(cells[column[i]], &end);
        if (end == cells[column[i]]) value[i] = (double)NAN;
    }
}

int main(void)
{
    char line[LONGEST_LINE];
    int column[COLUMNS], i;
    double value[COLUMNS], last = (double)NAN;
    baroarma_state state;
    baroarma_init(&state);
    if (fgets(line, sizeof line, stdin) == NULL || !find_columns(line, column)) return 2;
    printf("time_s,height_m,velocity_m_s,height_sd_m,velocity_sd_m_s\n");
    while (fgets(line, sizeof line, stdin) != NULL) {
        baroarma_real imu[6];
        baroarma_result now;
        read_row(line, column, value);
        for (i = 0; i < 6; i++) imu[i] = (baroarma_real)value[ACCEL + i];
        now = baroarma_step(&state, imu, imu + 3, (baroarma_real)value[PRESSURE],
                            (baroarma_real)(value[TIME] - last));
        last = value[TIME];
        printf("%.17g,%.17g,%.17g,%.17g,%.17g\n", last, (double)now.height, (double)now.velocity,
               (double)now.height_sd, (double)now.velocity_sd);
    }
    return 0;
}

#endif
