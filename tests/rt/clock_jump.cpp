// Loaded before the C library: the wall clock goes to and fro by hours and years with every look at it.
#include <ctime>

#include <dlfcn.h>
#include <sys/time.h>

namespace {

long jump() {
    static int looks = 0;
    constexpr long jumps[] = {0, -7200, 86'400, -1'000'000'000, 3600, 40'000'000};
    return jumps[looks++ % 6];
}

}  // namespace

extern "C" int clock_gettime(clockid_t clock, timespec* now) {
    static const auto real = reinterpret_cast<int (*)(clockid_t, timespec*)>(dlsym(RTLD_NEXT, "clock_gettime"));
    const int status = real(clock, now);
    if (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE) now->tv_sec += jump();
    return status;
}

extern "C" int gettimeofday(timeval* now, void* zone) {
    static const auto real = reinterpret_cast<int (*)(timeval*, void*)>(dlsym(RTLD_NEXT, "gettimeofday"));
    const int status = real(now, zone);
    now->tv_sec += jump();
    return status;
}

extern "C" time_t time(time_t* out) {
    static const auto real = reinterpret_cast<time_t (*)(time_t*)>(dlsym(RTLD_NEXT, "time"));
    const time_t now = real(nullptr) + jump();
    if (out) *out = now;
    return now;
}
