/* SPDX-License-Identifier: GPL-2.0-only
 *
 * trunnion_tp: a trajectory planner module for LinuxCNC 2.9 ([TRAJ]TPMOD = trunnion_tp).
 *
 * It plans nothing. Lines and arcs that LinuxCNC queues go over shared memory to the process `trunnion serve`, which
 * answers with plans: rows, one a servo period, down to a standstill inside all limits of all axes. The servo thread takes
 * one row a period. A process that is late, stopped or killed leaves a plan that ends in a controlled stop.
 *
 * In the servo thread: no allocation, no lock, no system call, a bounded number of steps.
 *
 * Module parameter: name=NAME of the shared memory below /dev/shm (trunnion-tp).
 */
#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "rtapi.h"
#include "rtapi_app.h"
#include "hal.h"
#include "motion.h"
#include "motion_types.h"
#include "tp.h"

#include "tp_memory.h"

MODULE_AUTHOR("Trunnion");
MODULE_DESCRIPTION("hands the motion queue to the planner process of Trunnion");
MODULE_LICENSE("GPL");
static char *name = TRUNNION_TP_MEMORY;
RTAPI_MP_STRING(name, "name of the shared memory");

enum { longest_queue = 4096, outputs_of_a_move = 8 };
static double const lost_after_s = 2;

/* A digital (value 0 or 1) or analog output that is set when a move begins. */
struct output { int index, analog; double value; };

/* What LinuxCNC has to be told of a move while it runs. */
struct move_note {
    int id, type;
    unsigned char enables;
    char at_speed;
    double speed;
    EmcPose end;
    struct state_tag_t tag;
    int output_count;
    struct output outputs[outputs_of_a_move];
};

static struct {
    int component;
    struct trunnion_tp_memory *shared;
    struct trunnion_reader reader;

    emcmot_status_t *status;
    void (*write_digital)(int, char);
    void (*write_analog)(int, double);

    /* What LinuxCNC has said for the moves to come. */
    int next_id, joint, synchronised;
    double tolerance, largest_speed, tool_length;
    int output_count;
    struct output outputs[outputs_of_a_move];

    struct move_note notes[longest_queue]; /* by number of the move, modulo */
    uint64_t written, begun, finished;     /* moves: handed over, running or run, behind us */
    uint32_t epoch, greeted, given_up;     /* of our orders; of those that the planner has answered; has refused */
    int must_begin;                        /* the next order has to say where it begins */
    int paused, aborting, spoke;

    EmcPose position, goal;
    double speed;
    uint64_t beat, beat_cycle;
} tp;

static void take_pose(double to[9], EmcPose const *from)
{
    to[0] = from->tran.x; to[1] = from->tran.y; to[2] = from->tran.z;
    to[3] = from->a; to[4] = from->b; to[5] = from->c;
    to[6] = from->u; to[7] = from->v; to[8] = from->w;
}

static void give_pose(EmcPose *to, double const from[9])
{
    to->tran.x = from[0]; to->tran.y = from[1]; to->tran.z = from[2];
    to->a = from[3]; to->b = from[4]; to->c = from[5];
    to->u = from[6]; to->v = from[7]; to->w = from[8];
}

static int same_pose(EmcPose const *a, EmcPose const *b)
{
    double p[9], q[9];
    int i;
    take_pose(p, a);
    take_pose(q, b);
    for (i = 0; i < 9; ++i) if (p[i] != q[i]) return 0;
    return 1;
}

static struct move_note *note_of(uint64_t number) { return &tp.notes[number % longest_queue]; }
static uint64_t moves_left(void) { return tp.written - tp.finished; }
static int stands(void)
{
    struct trunnion_plan const *plan = &tp.shared->plans.plan[tp.reader.in_use & 1];
    return tp.reader.in_use == 0 || tp.reader.next >= plan->first + plan->count;
}

/* The next move begins where the machine is. */
static void begin_anew(void)
{
    tp.goal = tp.position;
    tp.must_begin = 1;
    ++tp.epoch;
}

/* What is queued is forgotten. */
static void drop_all(void)
{
    tp.finished = tp.begun = tp.written;
    tp.aborting = 0;
    tp.output_count = 0;
    tp.speed = 0;
    tp.shared->orders.aborted = 0;
    begin_anew();
}

/* --- orders to the planner ------------------------------------------------------------------------------------ */

static struct trunnion_order order_to(EmcPose const *end, int kind)
{
    struct trunnion_order order;
    memset(&order, 0, sizeof order);
    order.number = tp.written + 1;
    order.epoch = tp.epoch;
    order.kind = kind;
    order.joint = tp.joint;
    order.tolerance = tp.tolerance;
    take_pose(order.end, end);
    order.tool_length = tp.tool_length;
    return order;
}

/* Where another tool is in use, what follows is planned for its length. LinuxCNC changes it at rest. */
static int take_tool(void)
{
    double length = tp.status->tool_offset.tran.z;
    if (length == tp.tool_length) return 1;
    if (moves_left() > 0) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trunnion_tp: the tool length changes under way\n");
        return 0;
    }
    tp.tool_length = length;
    begin_anew();
    return 1;
}

static int may_move(void)
{
    if (tp.synchronised) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trunnion_tp: motion synchronised with the spindle (G33, G76, G95) is not served\n");
        return 0;
    }
    return take_tool();
}

static int say_where_it_begins(void)
{
    struct trunnion_order order = order_to(&tp.position, trunnion_order_begin);
    if (!tp.must_begin) return 1;
    order.number = tp.written;
    if (!trunnion_order_write(&tp.shared->orders, &order)) return 0;
    tp.must_begin = 0;
    return 1;
}

static int hand_over(struct trunnion_order *order, EmcPose const *end, int type, double speed, double most,
                     unsigned char enables, char at_speed, struct state_tag_t tag)
{
    struct move_note *note = note_of(order->number);
    if (tp.aborting || moves_left() >= longest_queue - 1) return TP_ERR_FAIL;
    if (same_pose(end, &tp.goal) && order->kind == trunnion_order_line) return TP_ERR_ZERO_LENGTH;
    order->speed = speed < most ? speed : most;
    order->rapid = type == EMC_MOTION_TYPE_TRAVERSE;
    order->stop_first = at_speed != 0;
    if (!say_where_it_begins() || !trunnion_order_write(&tp.shared->orders, order)) return TP_ERR_FAIL;
    note->id = tp.next_id;
    note->type = type;
    note->enables = enables;
    note->at_speed = at_speed;
    note->speed = order->speed;
    note->end = *end;
    note->tag = tag;
    note->output_count = tp.output_count;
    memcpy(note->outputs, tp.outputs, sizeof tp.outputs);
    tp.output_count = 0;
    tp.goal = *end;
    tp.written = order->number;
    return TP_ERR_OK;
}

int tpAddLine(TP_STRUCT *const unused, EmcPose end, int type, double vel, double ini_maxvel, double acc,
              unsigned char enables, char atspeed, int indexrotary, struct state_tag_t tag)
{
    struct trunnion_order order;
    if (indexrotary != -1) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trunnion_tp: locking rotary axes are not served\n");
        return TP_ERR_FAIL;
    }
    if (!may_move()) return TP_ERR_FAIL;
    order = order_to(&end, trunnion_order_line);
    return hand_over(&order, &end, type, vel, ini_maxvel, enables, atspeed, tag);
}

int tpAddCircle(TP_STRUCT *const unused, EmcPose end, PmCartesian center, PmCartesian normal, int turn, int type,
                double vel, double ini_maxvel, double acc, unsigned char enables, char atspeed, struct state_tag_t tag)
{
    struct trunnion_order order;
    if (!may_move()) return TP_ERR_FAIL;
    order = order_to(&end, trunnion_order_arc);
    order.centre[0] = center.x; order.centre[1] = center.y; order.centre[2] = center.z;
    order.normal[0] = normal.x; order.normal[1] = normal.y; order.normal[2] = normal.z;
    order.turn = turn;
    return hand_over(&order, &end, type, vel, ini_maxvel, enables, atspeed, tag);
}

int tpAddRigidTap(TP_STRUCT *const unused, EmcPose end, double vel, double ini_maxvel, double acc,
                  unsigned char enables, double scale, struct state_tag_t tag)
{
    rtapi_print_msg(RTAPI_MSG_ERR, "trunnion_tp: rigid tapping (G33.1) is not served\n");
    return TP_ERR_FAIL;
}

int tpSetSpindleSync(TP_STRUCT *const unused, int spindle, double sync, int velocity_mode)
{
    tp.synchronised = sync != 0; /* LinuxCNC does not look at what this returns: the move is refused */
    return tp.synchronised ? TP_ERR_FAIL : TP_ERR_OK;
}

static int keep_output(int index, int analog, double value)
{
    struct output *output;
    if (tp.output_count == outputs_of_a_move) return TP_ERR_FAIL;
    output = &tp.outputs[tp.output_count++];
    output->index = index;
    output->analog = analog;
    output->value = value;
    return TP_ERR_OK;
}
int tpSetDout(TP_STRUCT *const unused, int index, unsigned char start, unsigned char end)
{
    return keep_output(index, 0, start);
}
int tpSetAout(TP_STRUCT *const unused, unsigned char index, double start, double end)
{
    return keep_output(index, 1, start);
}

/* --- one period ----------------------------------------------------------------------------------------------- */

/* Between two moves the next one counts as the present, as with LinuxCNC's own planner. */
static uint64_t present_number(void) { return tp.begun > tp.finished ? tp.begun : tp.finished + 1; }

/* A step goes to the end of the present move; then LinuxCNC sees another id, and pauses. */
static uint64_t run_through(void)
{
    if (tp.paused || tp.aborting) return 0;
    return tp.status->stepping ? present_number() : TRUNNION_RUN_ALL;
}

static void say_what_is_wished(void)
{
    struct trunnion_orders *orders = &tp.shared->orders;
    ++orders->cycles;
    orders->feed_scale = tp.status->net_feed_scale;
    orders->largest_speed = tp.largest_speed;
    __atomic_store_n(&orders->run_through, run_through(), __ATOMIC_RELEASE);
    orders->aborted = tp.aborting ? tp.epoch : 0;
}

/* Rows of the plan in use and of a newer one that was not looked at are not played any more. */
static void give_up_plans(void)
{
    uint64_t newest = __atomic_load_n(&tp.shared->plans.published, __ATOMIC_ACQUIRE);
    tp.reader.in_use = 0;
    tp.reader.looked_at = newest;
    __atomic_store_n(&tp.shared->plans.in_use, 0, __ATOMIC_RELAXED);
    __atomic_store_n(&tp.shared->plans.looked_at, newest, __ATOMIC_RELEASE);
}

/* Plans of an earlier epoch are given up, so that the planner does not wait for one of them to be looked at; it says when it
 * has made its last one. */
static int planner_answers(void)
{
    int answered = __atomic_load_n(&tp.shared->orders.answered, __ATOMIC_ACQUIRE) == tp.epoch;
    if (tp.must_begin) answered = 0;
    if (answered && tp.greeted == tp.epoch) return 1;
    give_up_plans();
    if (answered) tp.greeted = tp.epoch;
    return answered;
}

static int spindle_is_ready(struct move_note const *note)
{
    int i;
    if (!note->at_speed) return 1;
    for (i = 0; i < EMCMOT_MAX_SPINDLES; ++i)
        if (tp.status->spindle_status[i].state && !tp.status->spindle_status[i].at_speed) return 0;
    return 1;
}

static void set_outputs(struct move_note const *note)
{
    int i;
    for (i = 0; i < note->output_count; ++i) {
        struct output const *output = &note->outputs[i];
        if (output->analog) tp.write_analog(output->index, output->value);
        else tp.write_digital(output->index, output->value != 0);
    }
}

/* The row's move and all that were passed since the last one. */
static void begin_moves_to(uint64_t number)
{
    if (number > tp.written) number = tp.written;
    while (tp.begun < number) set_outputs(note_of(++tp.begun));
    if (number > 0 && number - 1 > tp.finished) tp.finished = number - 1;
}

static double way_between(double const a[9], double const b[9])
{
    double linear = 0, rotary = 0;
    int i;
    for (i = 0; i < 3; ++i) linear += (a[i] - b[i]) * (a[i] - b[i]);
    for (i = 3; i < 6; ++i) rotary += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(linear > 0 ? linear : rotary);
}

static void step(double period_s)
{
    struct trunnion_row const *row;
    double from[9];
    tp.speed = 0;
    if (!planner_answers()) return;
    trunnion_look(&tp.reader);
    if (tp.finished == tp.begun && tp.begun < tp.written && !spindle_is_ready(note_of(tp.begun + 1))) return;
    row = trunnion_next_row(&tp.reader);
    if (!row) return;
    take_pose(from, &tp.position);
    give_pose(&tp.position, row->position);
    tp.speed = way_between(row->position, from) / period_s;
    begin_moves_to((uint64_t)row->line);
}

/* Where the machine stands: a move that ends here is behind us, an abort is over. */
static void settle(void)
{
    struct trunnion_orders *orders = &tp.shared->orders;
    if (!stands() && tp.greeted == tp.epoch) return;
    if (tp.begun > tp.finished && orders->done_through >= tp.begun && orders->answered == tp.epoch)
        tp.finished = tp.begun;
    if (tp.aborting && (orders->stopped == tp.epoch || orders->answered != tp.epoch || tp.given_up == tp.epoch || tp.beat_cycle == 0))
        drop_all();
}

/* A planner that does not move is told once; what it planned has come to its standstill by then. */
static void watch_the_planner(void)
{
    struct trunnion_orders *orders = &tp.shared->orders;
    if (orders->beat != tp.beat) {
        tp.beat = orders->beat;
        tp.beat_cycle = orders->cycles;
        tp.spoke = 0;
    } else if ((orders->cycles - tp.beat_cycle) * orders->period_s > lost_after_s && moves_left() > 0) {
        if (!tp.spoke) rtapi_print_msg(RTAPI_MSG_ERR, "trunnion_tp: no answer from `trunnion serve`; is it running?\n");
        tp.spoke = 1;
        tp.beat_cycle = 0;
    }
    if (orders->refused != tp.shared->told && orders->refused > 0) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trunnion_tp: %s\n", orders->reason);
        tp.shared->told = orders->refused;
        tp.given_up = tp.epoch;
    }
}

static void tell_status(void)
{
    struct move_note const *note = note_of(tp.begun);
    double here[9], end[9];
    int moving = tp.begun > tp.finished;
    take_pose(here, &tp.position);
    take_pose(end, moving ? &note->end : &tp.position);
    tp.status->current_vel = tp.speed;
    tp.status->requested_vel = moving ? note->speed : 0;
    tp.status->distance_to_go = way_between(here, end);
    give_pose(&tp.status->dtg, end);
    tp.status->dtg.tran.x -= here[0]; tp.status->dtg.tran.y -= here[1]; tp.status->dtg.tran.z -= here[2];
    tp.status->dtg.a -= here[3]; tp.status->dtg.b -= here[4]; tp.status->dtg.c -= here[5];
    tp.status->tcqlen = moves_left();
    tp.status->spindleSync = 0;
    if (moves_left() > 0) tp.status->enables_queued = note_of(tp.finished + 1)->enables;
    else tp.status->enables_queued = tp.status->enables_new;
}

/* A pause with nothing queued is over, as with LinuxCNC's own planner: so it begins a program by a step. */
int tpRunCycle(TP_STRUCT *const unused, long period_ns)
{
    if (moves_left() == 0) tp.paused = 0;
    say_what_is_wished();
    watch_the_planner();
    step(period_ns * 1e-9);
    settle();
    tell_status();
    return TP_ERR_OK;
}

/* --- what LinuxCNC asks --------------------------------------------------------------------------------------- */

int tpGetPos(TP_STRUCT const *const unused, EmcPose *const pos) { *pos = tp.position; return TP_ERR_OK; }
int tpIsDone(TP_STRUCT *const unused) { return moves_left() == 0; }
int tpQueueDepth(TP_STRUCT *const unused) { return (int)moves_left(); }
int tpActiveDepth(TP_STRUCT *const unused) { return moves_left() > 0; }
int tpGetMotionType(TP_STRUCT *const unused) { return moves_left() > 0 ? note_of(tp.finished + 1)->type : 0; }
static struct move_note const *present_move(void) { return note_of(present_number()); }
int tpGetExecId(TP_STRUCT *const unused) { return moves_left() > 0 ? present_move()->id : 0; }
struct state_tag_t tpGetExecTag(TP_STRUCT *const unused)
{
    struct state_tag_t none;
    memset(&none, 0, sizeof none);
    return moves_left() > 0 ? present_move()->tag : none;
}
int tcqFull(TC_QUEUE_STRUCT const *const unused) { return moves_left() >= longest_queue - 64; }

/* --- what LinuxCNC says --------------------------------------------------------------------------------------- */

int tpSetPos(TP_STRUCT *const unused, EmcPose const *const pos)
{
    if (same_pose(pos, &tp.position) && same_pose(pos, &tp.goal)) return TP_ERR_OK;
    tp.position = *pos;
    drop_all();
    return TP_ERR_OK;
}
int tpClear(TP_STRUCT *const unused)
{
    if (moves_left() > 0) drop_all();
    tp.paused = 0;
    if (tp.status) tp.status->motionFlag |= EMCMOT_MOTION_INPOS_BIT;
    return TP_ERR_OK;
}
int tpAbort(TP_STRUCT *const unused)
{
    if (moves_left() > 0) tp.aborting = 1;
    return TP_ERR_OK;
}
int tpPause(TP_STRUCT *const unused) { tp.paused = 1; return TP_ERR_OK; }
int tpResume(TP_STRUCT *const unused) { tp.paused = 0; return TP_ERR_OK; }
int tpSetRunDir(TP_STRUCT *const unused, tc_direction_t dir) { return dir == TC_DIR_FORWARD ? TP_ERR_OK : TP_ERR_FAIL; }
int tpSetId(TP_STRUCT *const unused, int id) { tp.next_id = id; return TP_ERR_OK; }
int tpSetTermCond(TP_STRUCT *const unused, int cond, double tolerance)
{
    tp.joint = cond == TC_TERM_COND_STOP    ? trunnion_joint_stop
               : cond == TC_TERM_COND_EXACT ? trunnion_joint_exact
                                            : trunnion_joint_blend;
    tp.tolerance = tolerance;
    return TP_ERR_OK;
}
int tpSetVlimit(TP_STRUCT *const unused, double limit) { tp.largest_speed = limit > 0 ? limit : 0; return TP_ERR_OK; }
int tpSetVmax(TP_STRUCT *const unused, double vmax, double ini_maxvel) { return TP_ERR_OK; }
int tpSetAmax(TP_STRUCT *const unused, double amax) { return TP_ERR_OK; }
int tpSetCycleTime(TP_STRUCT *const unused, double seconds)
{
    if (tp.shared && seconds > 0) tp.shared->orders.period_s = seconds;
    return TP_ERR_OK;
}

void tpMotFunctions(void (*dio)(int, char), void (*aio)(int, double), void (*unlock)(int, int), int (*unlocked)(int),
                    double (*velocity_limit)(int), double (*acceleration_limit)(int))
{
    tp.write_digital = dio;
    tp.write_analog = aio;
}
void tpMotData(emcmot_status_t *status, emcmot_config_t *config)
{
    tp.status = status;
}

/* Of the functions that LinuxCNC calls, the ones that have nothing to do here. */
int tpCreate(TP_STRUCT *const unused, int queue_size, int id)
{
    tp.must_begin = 1;
    tp.epoch = 1;
    tp.largest_speed = HUGE_VAL;
    return tp.shared ? TP_ERR_OK : TP_ERR_FAIL;
}

/* --- the module ----------------------------------------------------------------------------------------------- */

static struct trunnion_tp_memory *shared_memory(void)
{
    struct trunnion_tp_memory *memory;
    int file;
    shm_unlink(name);
    file = shm_open(name, O_CREAT | O_EXCL | O_RDWR, 0600);
    if (file < 0) return 0;
    if (ftruncate(file, sizeof *memory) != 0) { close(file); return 0; }
    memory = mmap(0, sizeof *memory, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    if (memory == MAP_FAILED) return 0;
    memset(memory, 0, sizeof *memory); /* and every page is there before the servo thread touches it */
    return memory;
}

int rtapi_app_main(void)
{
    memset(&tp, 0, sizeof tp);
    tp.component = hal_init("trunnion_tp");
    if (tp.component < 0) return tp.component;
    tp.shared = shared_memory();
    if (!tp.shared) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trunnion_tp: no shared memory %s\n", name);
        hal_exit(tp.component);
        return -1;
    }
    trunnion_plans_begin(&tp.shared->plans, 9, 0);
    trunnion_reader_begin(&tp.reader, &tp.shared->plans);
    __atomic_store_n(&tp.shared->format, TRUNNION_TP_FORMAT, __ATOMIC_RELEASE);
    hal_ready(tp.component);
    return 0;
}

void rtapi_app_exit(void)
{
    if (tp.shared) {
        tp.shared->orders.closed = 1;
        munmap(tp.shared, sizeof *tp.shared);
    }
    shm_unlink(name);
    hal_exit(tp.component);
}

EXPORT_SYMBOL(tcqFull);
EXPORT_SYMBOL(tpAbort);
EXPORT_SYMBOL(tpActiveDepth);
EXPORT_SYMBOL(tpAddCircle);
EXPORT_SYMBOL(tpAddLine);
EXPORT_SYMBOL(tpAddRigidTap);
EXPORT_SYMBOL(tpClear);
EXPORT_SYMBOL(tpCreate);
EXPORT_SYMBOL(tpGetExecId);
EXPORT_SYMBOL(tpGetExecTag);
EXPORT_SYMBOL(tpGetMotionType);
EXPORT_SYMBOL(tpGetPos);
EXPORT_SYMBOL(tpIsDone);
EXPORT_SYMBOL(tpMotData);
EXPORT_SYMBOL(tpMotFunctions);
EXPORT_SYMBOL(tpPause);
EXPORT_SYMBOL(tpQueueDepth);
EXPORT_SYMBOL(tpResume);
EXPORT_SYMBOL(tpRunCycle);
EXPORT_SYMBOL(tpSetAmax);
EXPORT_SYMBOL(tpSetAout);
EXPORT_SYMBOL(tpSetCycleTime);
EXPORT_SYMBOL(tpSetDout);
EXPORT_SYMBOL(tpSetId);
EXPORT_SYMBOL(tpSetPos);
EXPORT_SYMBOL(tpSetRunDir);
EXPORT_SYMBOL(tpSetSpindleSync);
EXPORT_SYMBOL(tpSetTermCond);
EXPORT_SYMBOL(tpSetVlimit);
EXPORT_SYMBOL(tpSetVmax);
