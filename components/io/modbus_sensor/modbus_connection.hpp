// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/modbus_sensor/modbus_request.hpp"
#include "components/io/modbus_sensor/modbus_settings.hpp"
#include "components/io/sensor/name_lookup.hpp"
#include "components/io/sensor/waiting.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <termios.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace plumb {

// A TCP connection or a serial line over which libmodbus sends requests and receives replies. Failures of
// the connection are std::system_error.
//
// Nothing can end a call of libmodbus while it waits for bytes, so it is not called before the reply is
// complete. The waiting, which Pauses end, and the opening are ours.
class ModbusConnection {
public:
    // Whether requests over TCP have a number of their own; else libmodbus sends 0, and a reply to another
    // request of the same connection cannot be told from this one's.
    static constexpr bool numbers_requests = LIBMODBUS_VERSION_CHECK(3, 1, 11);

    ModbusConnection() = default;
    ModbusConnection(ModbusConnection&&) = default;
    ModbusConnection& operator=(ModbusConnection&&) = default;
    ~ModbusConnection() { close(); }

    // A socket that is connected and does not block, or with its settings a serial line. libmodbus opens
    // nothing, and needs no name.
    explicit ModbusConnection(Descriptor descriptor, const std::optional<SerialSettings>& serial = {})
        : descriptor_(std::move(descriptor)),
          serial_(serial),
          modbus_(serial ? modbus_new_rtu("line", serial->baud, serial->parity, 8, serial->stop_bits)
                         : modbus_new_tcp(nullptr, 0)) {
        if (!modbus_) throw std::bad_alloc();
        // libmodbus waits by select().
        if (number() >= FD_SETSIZE) throw std::system_error(EMFILE, std::generic_category());
        modbus_set_socket(modbus_.get(), number());
        modbus_set_byte_timeout(modbus_.get(), 0, 0);
    }

    // Until the time for each address.
    static ModbusConnection connected(const std::vector<NameLookup::Address>& addresses, Pauses& pauses,
                                      double seconds) {
        int error = EADDRNOTAVAIL;
        for (const NameLookup::Address& address : addresses) {
            Descriptor descriptor(
                socket(address.bytes.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
            const int number = descriptor.number();
            if (number < 0) {
                error = errno;
                continue;
            }
            const int yes = 1;
            setsockopt(number, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
            if (connect(number, reinterpret_cast<const sockaddr*>(&address.bytes), address.size) == 0)
                return ModbusConnection(std::move(descriptor));
            error = errno;
            if (error != EINPROGRESS) continue;
            if (pauses.wait(number, POLLOUT, seconds_now() + seconds) != Pauses::Woken::ready) {
                error = ETIMEDOUT;
                continue;
            }
            socklen_t size = sizeof error;
            getsockopt(number, SOL_SOCKET, SO_ERROR, &error, &size);
            if (error == 0) return ModbusConnection(std::move(descriptor));
        }
        throw std::system_error(error, std::generic_category());
    }

    // No other program may open the device meanwhile.
    static ModbusConnection opened(const std::string& path, const SerialSettings& settings) {
        Descriptor descriptor(open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
        const int number = descriptor.number();
        termios line{};
        if (number < 0 || tcgetattr(number, &line) != 0) fail();
        cfmakeraw(&line);
        line.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | PARENB | PARODD | CRTSCTS | HUPCL);
        line.c_cflag |= CLOCAL | CREAD;
        if (settings.stop_bits == 2) line.c_cflag |= CSTOPB;
        if (settings.parity != 'N') line.c_cflag |= PARENB;
        if (settings.parity == 'O') line.c_cflag |= PARODD;
        cfsetispeed(&line, settings.speed);
        cfsetospeed(&line, settings.speed);
        if (tcsetattr(number, TCSANOW, &line) != 0) fail();
        termios taken{};  // tcsetattr() succeeds where the driver takes a part of it
        if (tcgetattr(number, &taken) != 0) fail();
        if (cfgetospeed(&taken) != settings.speed)
            throw std::system_error(EINVAL, std::generic_category(),
                                    "the driver refuses " + std::to_string(settings.baud) + " baud");
        tcflush(number, TCIOFLUSH);
        if (ioctl(number, TIOCEXCL) != 0) fail();
        if (flock(number, LOCK_EX | LOCK_NB) != 0)  // TIOCEXCL does not keep root out
            throw std::system_error(EBUSY, std::generic_category());
        return ModbusConnection(std::move(descriptor), settings);
    }

    bool is_open() const noexcept { return static_cast<bool>(descriptor_); }
    int number() const noexcept { return descriptor_.number(); }

    void close() noexcept {
        if (serial_ && descriptor_) {
            // Else close() waits until a device takes the bytes that are left.
            tcflush(descriptor_.number(), TCIOFLUSH);
            // Else only root opens it again while another program has it open.
            ioctl(descriptor_.number(), TIOCNXCL);
        }
        modbus_.reset();  // leaves the descriptor open
        descriptor_.close();
    }

    // False if the line does not take it until then.
    bool send(const ModbusRequest& request, Pauses& pauses, double until) {
        const std::vector<std::uint8_t> bytes = request.bytes();
        const int size = static_cast<int>(bytes.size());
        if (serial_) modbus_set_slave(modbus_.get(), request.device);
        for (;;) {
#if LIBMODBUS_VERSION_CHECK(3, 1, 11)
            const int sent = modbus_send_raw_request_tid(modbus_.get(), bytes.data(), size, ++number_);
#else
            const int sent = modbus_send_raw_request(modbus_.get(), bytes.data(), size);
#endif
            if (sent >= 0) return true;
            if (errno == EMBBADDATA) return false;  // a part of it
            if (errno != EAGAIN && errno != EINTR) fail();
            if (pauses.wait(number(), POLLOUT, until) != Pauses::Woken::ready) return false;
        }
    }

    // The reply to the request that was sent last; silent if none comes until then.
    ModbusReply reply(const ModbusRequest& request, Pauses& pauses, double until) {
        for (std::size_t before = 0;;) {
            if (pauses.wait(number(), POLLIN, until) != Pauses::Woken::ready) return {};
            const std::size_t come = waiting();
            if (come == 0 || (come == before && hung_up())) lost();
            const Expected expected = serial_ ? on_line(request, come, before) : over_tcp(request, come);
            if (come >= expected.size || seconds_now() >= until)
                return serial_ ? from_line(request, pauses, until) : from_tcp(request);
            before = come;
            pauses.wait(std::min(until, seconds_now() + expected.rest));
        }
    }

    // Discards the received bytes, until none come for the time `silence`, and returns their number.
    std::size_t discard(Pauses& pauses, double silence, double until) {
        std::size_t all = 0;
        do {
            all += waiting();
            modbus_flush(modbus_.get());
            pauses.wait(seconds_now() + silence);
        } while (waiting() > 0 && seconds_now() < until && !pauses.stopped());
        return all;
    }

    // Received bytes that nobody has read.
    std::size_t waiting() const {
        int count = 0;
        if (ioctl(number(), FIONREAD, &count) != 0) fail();
        return static_cast<std::size_t>(std::max(count, 0));
    }

    // The end of a connection that is ready to be read and has no bytes.
    [[noreturn]] void lost() const {
        throw std::system_error(serial_ ? EIO : ECONNRESET, std::generic_category());
    }

private:
    struct Free {
        void operator()(modbus_t* modbus) const noexcept { modbus_free(modbus); }
    };

    // How many bytes the reply has, and the time after which they may have come, s.
    struct Expected {
        std::size_t size;
        double rest;
    };

    [[noreturn]] static void fail() {
        throw std::system_error(errno, std::generic_category());
    }

    Expected over_tcp(const ModbusRequest& request, std::size_t come) const {
        constexpr std::size_t shortest = modbus_tcp_head + modbus_exception_size;
        if (come < shortest) return {shortest, 0.001};
        std::uint8_t head[modbus_tcp_head];
        if (recv(number(), head, sizeof head, MSG_PEEK | MSG_DONTWAIT) < 0) fail();
        return {modbus_tcp_size(request, head), 0.001};
    }

    // The bytes of a line can be counted, but not seen before they are read. So a reply that has the size of
    // an exception is one if no byte follows.
    Expected on_line(const ModbusRequest& request, std::size_t come, std::size_t before) const {
        constexpr std::size_t checksum = 2, exception = modbus_exception_size + checksum;
        if (come < exception || (come == exception && before == exception)) return {exception, 0.001};
        const std::size_t whole = request.reply_size() + checksum;
        if (come == exception) return {whole, serial_->silence()};
        const double missing = static_cast<double>(whole) - static_cast<double>(come);
        return {whole, std::max(missing * serial_->byte_time(), 0.001)};
    }

    ModbusReply from_tcp(const ModbusRequest& request) {
        modbus_set_response_timeout(modbus_.get(), 0, 1);  // us: all bytes are there
        std::uint8_t bytes[MODBUS_MAX_ADU_LENGTH];
        const int size = modbus_receive_confirmation(modbus_.get(), bytes);
        if (size < 0 && errno < MODBUS_ENOBASE && errno != ETIMEDOUT) fail();
        // Nobody has asked for bytes after the end of the reply.
        if (size <= 0 || waiting() > 0) return modbus_wrong();
        return modbus_tcp_reply_of(request, number_, bytes, static_cast<std::size_t>(size));
    }

    // The reply among all bytes that come. A line without bias, and some drivers as they switch on, add
    // bytes, which libmodbus would take for a part of the reply.
    ModbusReply from_line(const ModbusRequest& request, Pauses& pauses, double until) {
        constexpr double longest_rest = 0.3;  // s, for which an adapter may keep back the rest of a reply
        std::vector<std::uint8_t> bytes;
        while (bytes.size() <= MODBUS_MAX_ADU_LENGTH) {
            std::uint8_t come[MODBUS_MAX_ADU_LENGTH];
            const ssize_t count = read(number(), come, sizeof come);
            if (count < 0 && errno != EAGAIN && errno != EINTR) fail();
            if (count > 0) bytes.insert(bytes.end(), come, come + count);
            if (waiting() > 0) continue;
            const ModbusReply reply = modbus_line_reply_of(request, bytes);
            const std::size_t whole = request.reply_size() + modbus_checksum_size;
            const bool alone = bytes.size() == whole || bytes.size() == modbus_shortest;
            if (alone && reply.status != ModbusReply::Status::wrong) return reply;
            const double now = seconds_now();
            const double end =
                bytes.size() >= whole ? now + serial_->silence() : std::min(until, now + longest_rest);
            // What comes behind a reply may be another one.
            if (pauses.wait(number(), POLLIN, end) != Pauses::Woken::ready) return reply;
        }
        return modbus_wrong();
    }

    bool hung_up() const {
        pollfd its{number(), POLLRDHUP, 0};
        return poll(&its, 1, 0) > 0;
    }

    Descriptor descriptor_;
    std::optional<SerialSettings> serial_;
    std::unique_ptr<modbus_t, Free> modbus_;
    std::uint16_t number_ = 0;  // of the last request over TCP
};

}  // namespace plumb
