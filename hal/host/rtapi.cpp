// SPDX-License-Identifier: GPL-2.0-or-later
// LinuxCNC's realtime interface, as hal_lib.so and stock modules call it: time, tasks and shared memory are
// those of the virtual-time host. Requests that need hardware are refused in a sentence.
#include <rtapi.h>
#include <rtapi_firmware.h>
#include <rtapi_parport.h>
#include <rtapi_string.h>
#include <spawn.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "hal/host/functions.hpp"
#include "hal/host/guard.hpp"
#include "hal/host/messages.hpp"
#include "hal/host/rtapi.hpp"
#include "hal/host/scheduler.hpp"
#include "hal/host/shared_memory.hpp"
#include "hal/linuxcnc_series.hpp"

using plumb::host::scheduler;
using plumb::host::Scheduler;
using plumb::host::shared_memory;

namespace plumb::host {

namespace {

MessageSink message_sink;
int message_files[] = {STDOUT_FILENO, STDERR_FILENO};
int message_level = RTAPI_MSG_ERR;
long clock_period = 0;  // ns, 0 until a module has set it

void print_formatted(msg_level_t level, const char* format, va_list arguments) {
    const Printing printing;
    va_list measured;
    va_copy(measured, arguments);
    const int length = std::vsnprintf(nullptr, 0, format, measured);
    va_end(measured);
    if (length < 0) return;
    std::string text(static_cast<std::size_t>(length) + 1, '\0');
    std::vsnprintf(text.data(), text.size(), format, arguments);
    text.pop_back();
    print_message(text, level != RTAPI_MSG_ALL);
}

rtapi_msg_handler_t message_handler = print_formatted;

int refuse(const char* consequence) {
    rtapi_print_msg(RTAPI_MSG_ERR, "The virtual-time host has no hardware: %s\n", consequence);
    return -ENODEV;
}

}  // namespace

void reset_rtapi() {
    clock_period = 0;
    message_level = RTAPI_MSG_ERR;
    message_handler = print_formatted;
}

void set_message_sink(MessageSink sink) {
    message_sink = std::move(sink);
}

void set_message_files(int output, int error) {
    message_files[0] = output < 0 ? STDOUT_FILENO : output;
    message_files[1] = error < 0 ? STDERR_FILENO : error;
}

void print_message(std::string_view text, bool error) {
    if (message_sink && message_sink(text, error)) return;
    while (!text.empty()) {
        const ssize_t count = write(message_files[error], text.data(), text.size());
        if (count < 0 && errno != EINTR) return;  // nobody listens
        if (count > 0) text.remove_prefix(static_cast<std::size_t>(count));
    }
}

}  // namespace plumb::host

extern "C" {

// Messages and text

void rtapi_print(const char* format, ...) {
    va_list arguments;
    va_start(arguments, format);
    plumb::host::message_handler(RTAPI_MSG_ALL, format, arguments);
    va_end(arguments);
}

void rtapi_print_msg(msg_level_t level, const char* format, ...) {
    if (plumb::host::message_level == RTAPI_MSG_NONE || static_cast<int>(level) > plumb::host::message_level)
        return;
    va_list arguments;
    va_start(arguments, format);
    plumb::host::message_handler(level, format, arguments);
    va_end(arguments);
}

void default_rtapi_msg_handler(msg_level_t level, const char* format, va_list arguments) {
    plumb::host::print_formatted(level, format, arguments);
}

void rtapi_set_msg_handler(rtapi_msg_handler_t handler) {
    plumb::host::message_handler = handler == nullptr ? plumb::host::print_formatted : handler;
}

rtapi_msg_handler_t rtapi_get_msg_handler() {
    return plumb::host::message_handler;
}

int rtapi_set_msg_level(int level) {
    plumb::host::message_level = level;
    return 0;
}

int rtapi_get_msg_level() {
    return plumb::host::message_level;
}

int rtapi_snprintf(char* buffer, unsigned long size, const char* format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const int length = std::vsnprintf(buffer, size, format, arguments);
    va_end(arguments);
    return length;
}

int rtapi_vsnprintf(char* buffer, unsigned long size, const char* format, va_list arguments) {
    return std::vsnprintf(buffer, size, format, arguments);
}

long simple_strtol(const char* text, char** end, int base) {
    return std::strtol(text, end, base);
}

void rtapi_argv_free(char** words) {
    if (words == nullptr) return;
    for (char** word = words; *word != nullptr; ++word) std::free(*word);
    std::free(words);
}

char** rtapi_argv_split(rtapi_gfp_t, const char* text, int* count) {
    const auto blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
    std::vector<std::string> found;
    for (const char* at = text; *at != '\0';) {
        if (blank(*at)) {
            ++at;
            continue;
        }
        const char* const begin = at;
        while (*at != '\0' && !blank(*at)) ++at;
        found.emplace_back(begin, at);
    }
    auto** const words = static_cast<char**>(std::calloc(found.size() + 1, sizeof(char*)));
    if (words == nullptr) return nullptr;
    for (std::size_t i = 0; i < found.size(); ++i) {
        words[i] = strdup(found[i].c_str());
        if (words[i] == nullptr) {
            rtapi_argv_free(words);
            return nullptr;
        }
    }
    if (count != nullptr) *count = static_cast<int>(found.size());
    return words;
}

// Identity and shared memory

int rtapi_init(const char*) {
    return shared_memory().take_identity();
}

int rtapi_exit(int) {
    shared_memory().give_identity_back();
    return 0;
}

int rtapi_shmem_new(int key, int, unsigned long size) {
    return shared_memory().attach(key, size);
}

int rtapi_shmem_getptr(int handle, void** address) {
    void* const found = shared_memory().address(handle);
    if (found == nullptr) return -EINVAL;
    *address = found;
    return 0;
}

int rtapi_shmem_delete(int handle, int) {
    return shared_memory().detach(handle);
}

// Time

long rtapi_clock_set_period(long period) {
    if (period == 0) return plumb::host::clock_period;
    if (period < 0) return -EINVAL;
    if (plumb::host::clock_period != 0) {
        rtapi_print_msg(RTAPI_MSG_ERR, "attempt to set period twice\n");
        return -EINVAL;
    }
    return plumb::host::clock_period = period;
}

long long rtapi_get_time() {
    plumb::host::count_reading(__builtin_return_address(0));
    return scheduler().read_clock();
}
long long rtapi_get_clocks() {
    plumb::host::count_reading(__builtin_return_address(0));
    return scheduler().read_clock();
}
void rtapi_delay(long span) {
    scheduler().delay(span < rtapi_delay_max() ? span : rtapi_delay_max());
}
long rtapi_delay_max() {
    return 10'000;
}

// Tasks

int rtapi_prio_highest() {
    return Scheduler::highest_priority;
}
int rtapi_prio_lowest() {
    return Scheduler::lowest_priority;
}

int rtapi_prio_next_higher(int priority) {
    if (priority < Scheduler::lowest_priority) return Scheduler::lowest_priority;
    return priority >= Scheduler::highest_priority ? Scheduler::highest_priority : priority + 1;
}

int rtapi_prio_next_lower(int priority) {
    if (priority > Scheduler::highest_priority) return Scheduler::highest_priority;
    return priority <= Scheduler::lowest_priority ? Scheduler::lowest_priority : priority - 1;
}

int rtapi_task_new(void (*code)(void*), void* argument, int priority, int, unsigned long stack_size, int) {
    return scheduler().create(code, argument, priority, stack_size);
}

int rtapi_task_delete(int task) {
    return scheduler().remove(task);
}

int rtapi_task_start(int task, unsigned long period) {
    const long base = plumb::host::clock_period;
    if (base <= 0) return -EINVAL;
    const long multiple = static_cast<long>(period) < base ? 1 : static_cast<long>(period) / base;
    return scheduler().start(task, multiple * base);
}

int rtapi_task_pause(int task) {
    return scheduler().pause(task);
}
int rtapi_task_resume(int) {
    return -ENOSYS;
}  // a task that never waits would never end
int rtapi_task_self() {
    return scheduler().running();
}
void rtapi_wait() {
    scheduler().wait();
}
#ifdef PLUMB_LINUXCNC_2_10
void rtapi_task_self_resync() {}  // no period is ever late
#endif

long long rtapi_task_pll_get_reference() {
    return scheduler().running() < 0 ? 0 : scheduler().time();
}
int rtapi_task_pll_set_correction(long) {
    return scheduler().running() < 0 ? -EINVAL : 0;
}  // nothing drifts

// The system

int rtapi_is_kernelspace() {
    return 0;
}
int rtapi_is_realtime() {
    return 0;
}
#ifdef PLUMB_LINUXCNC_2_10
rtapi_realtime_type_t rtapi_get_realtime_type() {
    return REALTIME_TYPE_NONE;
}
#endif
int rtapi_open_as_root(const char*, int) {
    return plumb::host::refuse("no file is opened as root");
}

int rtapi_spawn_as_root(pid_t* pid, const char*, const posix_spawn_file_actions_t*, const posix_spawnattr_t*,
                        char* const[], char* const[]) {
    plumb::host::refuse("no program is started as root");
    // hm2_eth waits for the program all the same. Nobody is a child of himself, so it waits for none, instead
    // of for any child of the host: the halcmd that waits for hm2_eth would be one.
    *pid = getpid();
    return EPERM;
}

int rtapi_spawnp_as_root(pid_t* pid, const char* path, const posix_spawn_file_actions_t* actions,
                         const posix_spawnattr_t* attributes, char* const arguments[],
                         char* const environment[]) {
    return rtapi_spawn_as_root(pid, path, actions, attributes, arguments, environment);
}

int rtapi_parport_get(const char*, rtapi_parport_t*, unsigned short, unsigned short, unsigned int) {
    return plumb::host::refuse("there is no parallel port");
}
void rtapi_parport_release(rtapi_parport_t*) {}

int rtapi_request_firmware(const rtapi_firmware**, const char*, rtapi_device*) {
    return plumb::host::refuse("no firmware is loaded");
}
void rtapi_release_firmware(const rtapi_firmware*) {}

struct rtapi_pci_dev;
struct rtapi_pci_driver;
int rtapi_pci_register_driver(rtapi_pci_driver*) {
    return plumb::host::refuse("there is no PCI bus");
}
void rtapi_pci_unregister_driver(rtapi_pci_driver*) {}
int rtapi_pci_enable_device(rtapi_pci_dev*) {
    return -ENODEV;
}
int rtapi_pci_disable_device(rtapi_pci_dev*) {
    return -ENODEV;
}
void* rtapi_pci_ioremap_bar(rtapi_pci_dev*, int) {
    return nullptr;
}
void rtapi_iounmap(volatile void*) {}

}  // extern "C"
