#ifndef BAROARMA_HEADER
#define BAROARMA_HEADER

#include "baroarma_config.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Units are SI; height, velocity and acceleration are positive up.  Body axes are the sensor's own, whatever
 * they are: a resting accelerometer reads the specific force, and that vector is up.  NaN: no new sample.
 *
 *     baroarma_state state;
 *     baroarma_init(&state);
 *     for (;;) {
 *         wait_for_the_imu(accel, gyro, &dt);
 *         baroarma_result now = baroarma_step(&state, accel, gyro, new_pressure_or_NAN(), dt);
 *         if (now.status == BAROARMA_OK) use(now.height, now.velocity);
 *     }
 *
 * The device must be at rest for the first second.  Nothing is allocated and nothing is global: several
 * states may live side by side.  Compile without -ffast-math, which would take the meaning from NaN. */

typedef enum {
    BAROARMA_ALIGNING = 0,    /* the first second, at rest: height and velocity are 0 */
    BAROARMA_OK = 1,          /* an estimate */
    BAROARMA_NO_REST = 2,     /* that second had no IMU sample or no gravity; the alignment begins anew */
    BAROARMA_BAD_INTERVAL = 3, /* dt is no number from 0 to an hour; the step was left out */
    BAROARMA_OVERFLOW = 4     /* a number has become too large; the alignment begins anew */
} baroarma_status;

typedef struct {
    baroarma_real height;       /* m above the start */
    baroarma_real velocity;     /* m/s */
    baroarma_real height_sd;    /* m */
    baroarma_real velocity_sd;  /* m/s */
    baroarma_real acceleration; /* m/s^2, vertical, without gravity; the last one where there is no sample */
    baroarma_status status;
} baroarma_result;

/* What the parts remember; nothing in here is for the user. */

typedef struct {
    baroarma_real time, low; /* a sum of intervals in two parts, s */
} baroarma_clock;

typedef struct {
    baroarma_real up[3];                   /* unit vector in body axes that points up */
    baroarma_real gyro_bias[3];            /* rad/s */
    baroarma_real gravity;                 /* mean modulus of the specific force, m/s^2 */
    baroarma_real accel_sd, gyro_sd;       /* of one sample and axis, m/s^2 and rad/s; NaN: not known */
    baroarma_real gravity_sd, gyro_bias_sd; /* of these two; NaN: not known */
} baroarma_rest;

@types@
typedef struct {
    int forces, rates;               /* new samples */
    baroarma_real modulus, rate[3];  /* their means, m/s^2 and rad/s */
} baroarma_part;

typedef struct {
    int samples;                             /* 0 before the first call */
    baroarma_clock elapsed;                  /* since the first call */
    int forces, rates, altitudes;            /* new samples so far */
    baroarma_real force[3], rate[3];         /* their means, m/s^2 and rad/s */
    baroarma_real force_spread, rate_spread; /* sums of their squared differences from these, all axes */
    baroarma_real modulus, altitude;         /* m/s^2 and m */
    baroarma_part parts[BAROARMA_PARTS];     /* the second in parts, whose means tell how sure the whole's is */
} baroarma_alignment;

typedef struct {
    int aligned;
    baroarma_alignment alignment;
    baroarma_real first_pressure, metres; /* Pa, NaN before there is one; T0/L times its (p/p0)^k, m */
    baroarma_real zero;                   /* height above the first pressure that counts as 0, m */
    baroarma_clock age;                   /* since the last acceleration */
    baroarma_real acceleration;           /* the last one, m/s^2 */
    baroarma_attitude attitude;
    baroarma_conditioning conditioning;
    baroarma_early early;
    baroarma_stillness stillness;
    baroarma_height height;
} baroarma_state;

/* Begin: aligning, height 0. */
void baroarma_init(baroarma_state *state);

/* Take one sample of all sensors.
 *
 * accel     specific force, m/s^2, body axes; NULL or any NaN: no new sample
 * gyro      angular rate, rad/s, likewise
 * pressure  Pa; NaN: no new sample (don't repeat the last one)
 * dt        time since the previous call, s; on the first call it has no effect
 */
baroarma_result baroarma_step(baroarma_state *state, const baroarma_real accel[3], const baroarma_real gyro[3],
                              baroarma_real pressure, baroarma_real dt);

#ifdef __cplusplus
}
#endif
#endif
