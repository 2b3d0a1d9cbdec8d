/* A stand-in for a typical vendor's SDK: one device, millimetres, z away from the user, no rates. */
#pragma once

#ifdef __cplusplus
extern "C" {
#endif

int sdk_open(void);                                 /* 0, or an error */
int sdk_position(double position_mm[3], int* grip); /* 0, or an error; grip: the user's switch is pressed */
int sdk_force(const double force[3]);               /* N; 0, or an error */
void sdk_sleep(double seconds);
void sdk_close(void);

#ifdef __cplusplus
}
#endif
