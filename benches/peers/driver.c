/* CPU time of one call of CasADi's generated Jacobian: the same loop as in main.rs. Prints nanoseconds. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

int plate_jacobian(const double** arg, double** res, long long int* iw, double* w, int mem);
int plate_jacobian_work(long long int* arg, long long int* res, long long int* iw, long long int* w);

enum { CALLS = 200000, RUNS = 21, MOST = 64 };

static int ascending(const void* a, const void* b) {
  double x = *(const double*)a, y = *(const double*)b;
  return (x > y) - (x < y);
}

int main(void) {
  double x[9] = {0.02, 0.7, 0.13, -0.05, 0.4, 0.1, 3.0, -0.8, 2.0}, out[MOST] = {0}, times[RUNS];
  long long int na, nr, ni, nw;
  plate_jacobian_work(&na, &nr, &ni, &nw);
  const double** arg = calloc(na + 1, sizeof *arg);
  double** res = calloc(nr + 1, sizeof *res);
  long long int* iw = calloc(ni + 1, sizeof *iw);
  double* w = calloc(nw + 1, sizeof *w);
  arg[0] = x;
  res[0] = out;
  for (int r = 0; r < RUNS; ++r) {
    struct timespec from, to;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &from);
    for (int i = 0; i < CALLS; ++i) {
      x[0] = 0.02 + 1e-9 * i;
      plate_jacobian(arg, res, iw, w, 0);
      __asm__ volatile("" : : "r"(out) : "memory");
    }
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &to);
    times[r] = ((to.tv_sec - from.tv_sec) * 1e9 + (to.tv_nsec - from.tv_nsec)) / CALLS;
  }
  qsort(times, RUNS, sizeof *times, ascending);
  printf("%g\n", times[RUNS / 2]);
  return 0;
}
