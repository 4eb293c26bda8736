/* SPDX-License-Identifier: GPL-2.0-only
 *
 * What the module trunnion_tp does in the servo thread, without LinuxCNC: proved to call no system and to allocate nothing, and timed.
 *
 *   servo_thread           proves it: 100 000 periods where any system call is the end (seccomp, strict); exit status 0 or not
 *   servo_thread PERIODS   times so many periods one after another, under SCHED_FIFO where that is allowed, beside arithmetic of always
 *                          the same length; then 20 000 of 1 ms by the clock; then the longest there can be, which passes a full queue
 *
 * In every period LinuxCNC hands over a line, runs the cycle and asks for the place; what the planner's process does lies outside
 * of what is timed. Periods in which the system took the processor away (an involuntary context switch) are counted apart.
 */
#define _GNU_SOURCE
#include <sched.h>
#include <linux/seccomp.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>

#include "tpmod/trunnion_tp.c"

enum { rows_of_a_plan = 4096, longest_us = 100, proved_periods = 100000 };

/* --- what LinuxCNC has around the module ----------------------------------------------------------------------- */

static int in_period, allocations, messages;
static emcmot_status_t status;
static volatile int outputs_set;

void rtapi_print_msg(msg_level_t level, const char *text, ...) { ++messages; }
int hal_init(const char *component) { return 1; }
int hal_exit(int component) { return 0; }
int hal_ready(int component) { return 0; }
static void set_digital(int index, char value) { ++outputs_set; }
static void set_analog(int index, double value) { ++outputs_set; }

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
extern void __libc_free(void *);
void *malloc(size_t size) { allocations += in_period; return __libc_malloc(size); }
void *calloc(size_t count, size_t size) { allocations += in_period; return __libc_calloc(count, size); }
void *realloc(void *from, size_t size) { allocations += in_period; return __libc_realloc(from, size); }
void free(void *what) { allocations += in_period; __libc_free(what); }

static int start_module(void)
{
    static char own_name[40];
    snprintf(own_name, sizeof own_name, "trunnion-servo-thread-%d", getpid());
    name = own_name;
    if (rtapi_app_main() != 0) return -1;
    status.net_feed_scale = 1;
    tpMotFunctions(set_digital, set_analog, 0, 0, 0, 0);
    tpMotData(&status, 0);
    tpCreate(0, 2000, 1);
    return tpSetCycleTime(0, 1e-3);
}

/* --- what the planner's process does --------------------------------------------------------------------------- */

static void row_at(struct trunnion_row *row, uint64_t number, uint64_t move)
{
    int i;
    for (i = 0; i < 6; ++i) row->position[i] = 1e-3 * (i + 1) * number;
    row->line = (int64_t)move;
}

/* A move a row, so that every period begins one. */
static void plan(void)
{
    static uint64_t ordered;
    struct trunnion_order order;
    struct trunnion_plans *plans = &tp.shared->plans;
    struct trunnion_plan *to;
    uint64_t k;
    while (trunnion_order_read(&tp.shared->orders, &order)) {
        if (order.kind == trunnion_order_begin) tp.shared->orders.answered = order.epoch;
        else ordered = order.number;
    }
    ++tp.shared->orders.beat;
    if (plans->in_use && plans->next - plans->plan[plans->in_use & 1].first < rows_of_a_plan / 2) return;
    to = trunnion_plan_to_fill(plans);
    if (!to) return;
    to->first = plans->next;
    to->branch = to->first + rows_of_a_plan;
    to->count = rows_of_a_plan;
    for (k = 0; k < to->count; ++k) row_at(&to->rows[k], to->first + k, ordered + k);
    trunnion_publish(plans);
}

/* --- a period --------------------------------------------------------------------------------------------------- */

static void period(void)
{
    static int line;
    static EmcPose end;
    static struct state_tag_t tag;
    EmcPose place;
    in_period = 1;
    end.tran.x += 1;
    tpSetId(0, ++line);
    tpSetTermCond(0, TC_TERM_COND_PARABOLIC, 0.01);
    if (line % 8 == 0) tpSetDout(0, 0, 1, 0);
    tpAddLine(0, end, 2, 50, 100, 1000, 0, 0, -1, tag);
    tpRunCycle(0, 1000000);
    tpGetPos(0, &place);
    in_period = 0;
}

static void arithmetic(void)
{
    volatile double x = 1.5;
    int k;
    for (k = 0; k < 20; ++k) x = sqrt(x + 0.5);
}

/* --- proof ------------------------------------------------------------------------------------------------------ */

static int prove(void)
{
    int result = 0;
    pid_t child = fork();
    if (child == 0) {
        long k;
        if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) syscall(SYS_exit, 3);
        for (k = 0; k < proved_periods; ++k) {
            plan();
            period();
        }
        syscall(SYS_exit, allocations != 0 ? 4 : messages != 0 ? 5 : tp.reader.next < proved_periods / 2 ? 6 : 0);
    }
    if (child < 0 || waitpid(child, &result, 0) < 0) return 3;
    if (WIFSIGNALED(result)) {
        fprintf(stderr, "a system call in the servo thread\n");
        return 1;
    }
    if (WEXITSTATUS(result)) fprintf(stderr, "%d: 3 no seccomp, 4 allocations, 5 messages, 6 it does not move\n", WEXITSTATUS(result));
    else printf("%d periods: no system call, no allocation\n", proved_periods);
    return WEXITSTATUS(result);
}

/* --- times ------------------------------------------------------------------------------------------------------ */

static int64_t now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1000000000ll * now.tv_sec + now.tv_nsec;
}

static long switches(void)
{
    struct rusage usage;
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_nivcsw;
}

static void next_millisecond(void)
{
    static struct timespec at;
    if (at.tv_sec == 0) clock_gettime(CLOCK_MONOTONIC, &at);
    at.tv_nsec += 1000000;
    if (at.tv_nsec >= 1000000000) { at.tv_nsec -= 1000000000; ++at.tv_sec; }
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, 0);
}
static void at_once(void) {}

static void time_it(const char *what, void (*work)(void), long periods, void (*before_each)(void))
{
    static uint32_t counts[longest_us * 1000 + 1];
    double sum = 0;
    long k, switched = 0, counted = 0, above = 0, passed = 0;
    int64_t longest = 0;
    memset(counts, 0, sizeof counts);
    for (k = 0; k < periods; ++k) {
        long before, after;
        int64_t begin, ns;
        plan();
        before_each();
        before = switches();
        begin = now_ns();
        work();
        ns = now_ns() - begin;
        after = switches();
        if (after != before) { ++switched; continue; }
        ++counted;
        sum += ns;
        above += ns > 10000;
        if (ns > longest) longest = ns;
        ++counts[ns < longest_us * 1000 ? ns : longest_us * 1000];
    }
    for (k = 0; passed < 0.9999 * counted; ++k) passed += counts[k];
    printf("%s: mean %.3f us, 99.99 %% below %.3f us, above 10 us %.1e of %ld, longest %.1f us, with an involuntary switch %ld\n", what,
           sum / counted / 1e3, (k - 1) / 1e3, (double)above / counted, counted, longest / 1e3, switched);
}

/* One row that lies behind all moves of a full queue, each with all the outputs that it can have. */
static void pass_full_queue(void)
{
    static struct state_tag_t tag;
    EmcPose end = tp.goal;
    int64_t begin, longest = 0;
    int turn, k, i;
    for (turn = 0; turn < 20; ++turn) {
        struct trunnion_plan *to;
        int before = outputs_set;
        drop_all();
        for (k = 0; k < longest_queue - 2; ++k) {
            for (i = 0; i < outputs_of_a_move; ++i) tpSetDout(0, i, 1, 0);
            end.tran.x += 1;
            tpAddLine(0, end, 2, 50, 100, 1000, 0, 0, -1, tag);
            if (k % 64 == 0) plan();
        }
        plan();
        tpRunCycle(0, 1000000);
        to = trunnion_plan_to_fill(&tp.shared->plans);
        to->first = to->branch = tp.reader.next;
        to->count = 1;
        row_at(&to->rows[0], to->first, tp.written);
        trunnion_publish(&tp.shared->plans);
        begin = now_ns();
        tpRunCycle(0, 1000000);
        begin = now_ns() - begin;
        if (begin > longest) longest = begin;
        if (outputs_set - before < 8 * (longest_queue - 2)) printf("not all were passed: %d\n", outputs_set - before);
    }
    printf("a period that passes %d moves with 8 outputs each: at most %.1f us\n", longest_queue - 2, longest / 1e3);
}

int main(int count, char **words)
{
    struct sched_param priority = {.sched_priority = 50};
    int result = 0;
    if (start_module() != 0) return 2;
    if (count < 2) {
        result = prove();
    } else {
        mlockall(MCL_CURRENT | MCL_FUTURE);
        printf("SCHED_FIFO: %s\n", sched_setscheduler(0, SCHED_FIFO, &priority) == 0 ? "yes" : "not allowed");
        time_it("servo thread", period, atol(words[1]), at_once);
        time_it("arithmetic", arithmetic, atol(words[1]), at_once);
        time_it("servo thread by the clock", period, 20000, next_millisecond);
        time_it("arithmetic by the clock", arithmetic, 20000, next_millisecond);
        pass_full_queue();
        if (allocations || messages) result = 1;
    }
    rtapi_app_exit();
    return result;
}
