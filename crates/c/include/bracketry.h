/* Controllers of problem files, for C and C++. Made by cbindgen from crates/c/src; docs/c.md is the guide. */

#ifndef BRACKETRY_H
#define BRACKETRY_H

#include <stddef.h>
#include <stdint.h>

/**
 * Whether a call worked.
 */
typedef enum BracketryCode {
  /**
   * It worked.
   */
  BRACKETRY_CODE_OK = 0,
  /**
   * A pointer is null, or not aligned.
   */
  BRACKETRY_CODE_NULL = 1,
  /**
   * An array has another length than it has to have.
   */
  BRACKETRY_CODE_LENGTH = 2,
  /**
   * A number that makes no sense here, such as NaN.
   */
  BRACKETRY_CODE_VALUE = 3,
  /**
   * A text is not UTF-8.
   */
  BRACKETRY_CODE_TEXT = 4,
  /**
   * The controller has nothing of that name.
   */
  BRACKETRY_CODE_NAME = 5,
  /**
   * The time of a measurement cannot be used.
   */
  BRACKETRY_CODE_TIME = 6,
  /**
   * The problem file, or a model that it names, is not as it has to be.
   */
  BRACKETRY_CODE_PROBLEM = 7,
  /**
   * The controller cannot be made or cannot go on.
   */
  BRACKETRY_CODE_CONTROLLER = 8,
  /**
   * A bug in the library. The controller can only be freed.
   */
  BRACKETRY_CODE_PANIC = 9,
} BracketryCode;

/**
 * How a sample went.
 */
typedef enum BracketryOutcome {
  /**
   * A new input from a program solved to full accuracy.
   */
  BRACKETRY_OUTCOME_SOLVED = 0,
  /**
   * A new input from a program solved to reduced accuracy.
   */
  BRACKETRY_OUTCOME_INACCURATE = 1,
  /**
   * A new input, but a hard bound cannot be kept: the violation is as small as it can be.
   */
  BRACKETRY_OUTCOME_INFEASIBLE = 2,
  /**
   * The shrinking horizon is (nearly) used up: the plan is played out.
   */
  BRACKETRY_OUTCOME_PLAYED_OUT = 3,
  /**
   * The input of the failure policy.
   */
  BRACKETRY_OUTCOME_FALLBACK = 4,
} BracketryOutcome;

/**
 * Where an input comes from.
 */
typedef enum BracketrySource {
  /**
   * A program solved for this measurement.
   */
  BRACKETRY_SOURCE_PROGRAM = 0,
  /**
   * A program solved ahead, moved to this measurement by the tangential predictor.
   */
  BRACKETRY_SOURCE_TANGENT = 1,
  /**
   * The last usable plan, shifted.
   */
  BRACKETRY_SOURCE_PLAN = 2,
  /**
   * The law that brakes.
   */
  BRACKETRY_SOURCE_BRAKE = 3,
  /**
   * The input of rest.
   */
  BRACKETRY_SOURCE_REST = 4,
} BracketrySource;

/**
 * Why the failure policy decided.
 */
typedef enum BracketryReason {
  /**
   * It did not.
   */
  BRACKETRY_REASON_NONE = 0,
  /**
   * Nothing was measured: every entry of the measurement is NaN.
   */
  BRACKETRY_REASON_LOST_SAMPLE = 1,
  /**
   * The measurement has an entry that is not finite.
   */
  BRACKETRY_REASON_MEASUREMENT = 2,
  /**
   * The linearization has an entry that is not finite.
   */
  BRACKETRY_REASON_LINEARIZATION = 3,
  /**
   * The cost along the plan is not finite.
   */
  BRACKETRY_REASON_COST = 4,
  /**
   * The time of the sample was over before there was a solution.
   */
  BRACKETRY_REASON_TIME_LIMIT = 5,
  /**
   * The quadratic program reached its limit of iterations or time.
   */
  BRACKETRY_REASON_QP_LIMIT = 6,
  /**
   * The quadratic program was not solved.
   */
  BRACKETRY_REASON_QP_FAILED = 7,
} BracketryReason;

/**
 * Lists of names that a controller has.
 */
typedef enum BracketryKind {
  /**
   * The states of the model: the entries of x.
   */
  BRACKETRY_KIND_STATE = 0,
  /**
   * The inputs: the entries of u.
   */
  BRACKETRY_KIND_INPUT = 1,
  /**
   * What is measured: the entries of y.
   */
  BRACKETRY_KIND_MEASUREMENT = 2,
  /**
   * The references of cost and constraints.
   */
  BRACKETRY_KIND_REFERENCE = 3,
  /**
   * The parameters that can be changed.
   */
  BRACKETRY_KIND_PARAMETER = 4,
  /**
   * The states that have a target.
   */
  BRACKETRY_KIND_TARGET = 5,
} BracketryKind;

/**
 * A controller of a problem file. One thread at a time may use it.
 */
typedef struct BracketryController BracketryController;

/**
 * What a sample tells besides the input.
 */
typedef struct BracketryStatus {
  /**
   * Number of the sample, from 0.
   */
  uint64_t sample;
  /**
   * Samples before it that got no measurement.
   */
  uint64_t missed;
  /**
   * How it went.
   */
  enum BracketryOutcome outcome;
  /**
   * Where the input comes from.
   */
  enum BracketrySource source;
  /**
   * Why the failure policy decided.
   */
  enum BracketryReason reason;
  /**
   * Time of the preparation, s.
   */
  double prepare_seconds;
  /**
   * Time from the measurement to the input, s.
   */
  double feedback_seconds;
} BracketryStatus;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The name of an outcome (a `BracketryOutcome`) as in other reports, such as `solved`; `unknown` for another number. Not to be freed.
 */
const char *bracketry_outcome_name(uint32_t outcome);

/**
 * The name of a source (a `BracketrySource`), such as `program`; `unknown` for another number. Not to be freed.
 */
const char *bracketry_source_name(uint32_t source);

/**
 * The name of a reason (a `BracketryReason`), such as `lost_sample`; `unknown` for another number. Not to be freed.
 */
const char *bracketry_reason_name(uint32_t reason);

/**
 * What went wrong in the last call of this thread that failed, with a remedy; empty if none did. It holds until the next call that
 * fails; not to be freed.
 */
const char *bracketry_last_error(void);

/**
 * The version of the library, such as `0.1.0`. Not to be freed.
 */
const char *bracketry_version(void);

/**
 * The controller of a problem file, whose models are looked for beside it. Makes the first plan, which may take long.
 *
 * `error`, unless it is null, gets the code. Returns null where it is not `BRACKETRY_CODE_OK`. To be freed by
 * `bracketry_controller_free`.
 *
 * # Safety
 * `path` is null or a text that ends with a zero.
 */
struct BracketryController *bracketry_controller_new(const char *path, enum BracketryCode *error);

/**
 * As `bracketry_controller_new`, from the text of a problem file and that of the model, whatever the problem calls it.
 *
 * # Safety
 * The texts are null or end with a zero.
 */
struct BracketryController *bracketry_controller_from_text(const char *problem,
                                                           const char *model,
                                                           enum BracketryCode *error);

/**
 * Frees a controller; null is nothing to free.
 *
 * # Safety
 * The handle comes from this library and has not been freed.
 */
void bracketry_controller_free(struct BracketryController *controller);

/**
 * The input `u` (length `m`, one entry per input) for the measurement `y` (length `n`, one entry per measured quantity) taken at the
 * time `t` in seconds. It is to be held for one period.
 *
 * The clock is the caller's; its first time is that of the first sample, and times are rounded to samples. Samples that have
 * passed without a measurement are compensated. An entry of `y` is NaN where nothing was measured; the input is then that of the
 * failure policy, which `status` tells. `status` may be null. Where the code is not `BRACKETRY_CODE_OK`, the controller is as
 * it was, and `u` and `status` are not written.
 *
 * # Safety
 * `y` and `u` have room for `n` and `m` numbers; the handle is one.
 */
enum BracketryCode bracketry_controller_step(struct BracketryController *controller,
                                             double t,
                                             const double *y,
                                             size_t n,
                                             double *u,
                                             size_t m,
                                             struct BracketryStatus *status);

/**
 * Does everything for the next sample that does not need its measurement.
 *
 * # Safety
 * The handle is one.
 */
enum BracketryCode bracketry_controller_prepare(struct BracketryController *controller);

/**
 * As `bracketry_controller_step` for the next sample, without a clock, and as fast as possible after `bracketry_controller_prepare`.
 *
 * # Safety
 * As for `bracketry_controller_step`.
 */
enum BracketryCode bracketry_controller_feedback(struct BracketryController *controller,
                                                 const double *y,
                                                 size_t n,
                                                 double *u,
                                                 size_t m,
                                                 struct BracketryStatus *status);

/**
 * The input of the next sample, whose measurement has not come in time: that of the failure policy.
 *
 * # Safety
 * As for `bracketry_controller_step`.
 */
enum BracketryCode bracketry_controller_lost(struct BracketryController *controller,
                                             double *u,
                                             size_t m,
                                             struct BracketryStatus *status);

/**
 * Starts again from the initial state of the problem, at sample 0. Changes of references, parameters, bounds, and targets stay.
 *
 * # Safety
 * The handle is one.
 */
enum BracketryCode bracketry_controller_reset(struct BracketryController *controller);

/**
 * As `bracketry_controller_reset`, from the state `x0` (length `n`, one entry per state).
 *
 * # Safety
 * `x0` has `n` numbers; the handle is one.
 */
enum BracketryCode bracketry_controller_reset_to(struct BracketryController *controller, const double *x0, size_t n);

/**
 * The states and inputs that the last sample's program predicts: `x` gets the states at the N + 1 grid points of the horizon, one
 * point after the other (`nx` = (N + 1) · number of states), `u` the inputs of the N intervals (`nu` = N · number of inputs). N is
 * `bracketry_controller_horizon`.
 *
 * # Safety
 * `x` and `u` have room for `nx` and `nu` numbers; the handle is one.
 */
enum BracketryCode bracketry_controller_predict(struct BracketryController *controller,
                                                double *x,
                                                size_t nx,
                                                double *u,
                                                size_t nu);

/**
 * Gives a reference a value, from the next preparation on.
 *
 * # Safety
 * `name` is null or a text that ends with a zero; the handle is one.
 */
enum BracketryCode bracketry_controller_set_reference(struct BracketryController *controller,
                                                      const char *name,
                                                      double value);

/**
 * Gives a reference `n` values at the next samples, one per period from the next sample on; the last one holds.
 *
 * # Safety
 * `name` is null or a text that ends with a zero; `values` has `n` numbers; the handle is one.
 */
enum BracketryCode bracketry_controller_set_reference_ahead(struct BracketryController *controller,
                                                            const char *name,
                                                            const double *values,
                                                            size_t n);

/**
 * Gives `n` parameters of the controller's model values, from the next preparation on: all of them, or none where one is refused.
 * Each has to be one of `live_parameters` in the problem file.
 *
 * # Safety
 * `names` has `n` pointers, each null or to a text that ends with a zero; `values` has `n` numbers; the handle is one.
 */
enum BracketryCode bracketry_controller_set_parameters(struct BracketryController *controller,
                                                       const char *const *names,
                                                       const double *values,
                                                       size_t n);

/**
 * Replaces the bounds of a state or an input; infinite ends are none.
 *
 * # Safety
 * `name` is null or a text that ends with a zero; the handle is one.
 */
enum BracketryCode bracketry_controller_set_bounds(struct BracketryController *controller,
                                                   const char *name,
                                                   double min,
                                                   double max);

/**
 * Replaces the value of the target of a state.
 *
 * # Safety
 * `name` is null or a text that ends with a zero; the handle is one.
 */
enum BracketryCode bracketry_controller_set_target(struct BracketryController *controller,
                                                   const char *name,
                                                   double value);

/**
 * Number of names of a kind (a `BracketryKind`); 0 for another kind, and for a null pointer.
 *
 * # Safety
 * The handle is one.
 */
size_t bracketry_controller_count(struct BracketryController *controller, uint32_t kind);

/**
 * A name by its kind (a `BracketryKind`) and index from 0; null where there is none. It belongs to the controller.
 *
 * # Safety
 * The handle is one.
 */
const char *bracketry_controller_name(struct BracketryController *controller, uint32_t kind, size_t index);

/**
 * The sampling period in seconds; NaN for a null pointer.
 *
 * # Safety
 * The handle is one.
 */
double bracketry_controller_period(struct BracketryController *controller);

/**
 * Number of intervals N of the prediction; 0 for a null pointer.
 *
 * # Safety
 * The handle is one.
 */
size_t bracketry_controller_horizon(struct BracketryController *controller);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BRACKETRY_H */
