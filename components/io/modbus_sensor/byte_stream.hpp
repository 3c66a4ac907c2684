// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/modbus_sensor/modbus_settings.hpp"
#include "components/io/sensor/name_lookup.hpp"
#include "components/io/sensor/waiting.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <termios.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

namespace plumb {

// A TCP connection or a serial line, of which no call waits longer than it is told. Failures of the
// connection are std::system_error.
class ByteStream {
public:
    ByteStream() = default;
    ByteStream(ByteStream&&) = default;
    ByteStream& operator=(ByteStream&&) = default;
    ~ByteStream() { close(); }

    // Until the time for each address.
    static ByteStream connected(const std::vector<NameLookup::Address>& addresses, Pauses& pauses,
                                double seconds) {
        int error = EADDRNOTAVAIL;
        for (const NameLookup::Address& address : addresses) {
            ByteStream stream;
            stream.descriptor_ =
                Descriptor(socket(address.bytes.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
            const int number = stream.descriptor_.number();
            if (number < 0) {
                error = errno;
                continue;
            }
            const int yes = 1;
            setsockopt(number, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
            if (connect(number, reinterpret_cast<const sockaddr*>(&address.bytes), address.size) == 0)
                return stream;
            error = errno;
            if (error != EINPROGRESS) continue;
            if (pauses.wait(number, POLLOUT, seconds_now() + seconds) != Pauses::Woken::ready) {
                error = ETIMEDOUT;
                continue;
            }
            socklen_t size = sizeof error;
            getsockopt(number, SOL_SOCKET, SO_ERROR, &error, &size);
            if (error == 0) return stream;
        }
        throw std::system_error(error, std::generic_category());
    }

    // No other program may open the device meanwhile.
    static ByteStream opened(const std::string& path, const SerialSettings& settings) {
        ByteStream stream;
        stream.descriptor_ = Descriptor(open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
        const int number = stream.descriptor_.number();
        termios line{};
        if (number < 0 || tcgetattr(number, &line) != 0) fail();
        if (ioctl(number, TIOCEXCL) != 0) fail();
        stream.serial_ = true;
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
        return stream;
    }

    bool is_open() const noexcept { return static_cast<bool>(descriptor_); }
    int number() const noexcept { return descriptor_.number(); }

    void close() noexcept {
        // Else close() waits until a device takes the bytes that are left.
        if (serial_ && descriptor_) tcflush(descriptor_.number(), TCIOFLUSH);
        descriptor_.close();
    }

    // False if the time has come, or the program is to end.
    bool send(const std::vector<std::uint8_t>& bytes, Pauses& pauses, double until) {
        std::size_t sent = 0;
        while (sent < bytes.size()) {
            const ssize_t count =
                serial_ ? write(number(), bytes.data() + sent, bytes.size() - sent)
                        : ::send(number(), bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
            if (count > 0)
                sent += static_cast<std::size_t>(count);
            else if (count < 0 && errno != EAGAIN && errno != EINTR)
                fail();
            else if (pauses.wait(number(), POLLOUT, until) != Pauses::Woken::ready)
                return false;
        }
        return true;
    }

    // Appends the received bytes, at most 512; none if none came until then.
    std::size_t receive(std::vector<std::uint8_t>& bytes, Pauses& pauses, double until) {
        if (pauses.wait(number(), POLLIN, until) != Pauses::Woken::ready) return 0;
        std::uint8_t buffer[512];
        const ssize_t count = read(number(), buffer, sizeof buffer);
        if (count < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
        if (count < 0) fail();
        if (count == 0) throw std::system_error(serial_ ? EIO : ECONNRESET, std::generic_category());
        bytes.insert(bytes.end(), buffer, buffer + count);
        return static_cast<std::size_t>(count);
    }

    // Discards the received bytes, at most 64 KiB at a time; returns their number.
    std::size_t discard(Pauses& pauses) {
        std::vector<std::uint8_t> bytes;
        while (bytes.size() < 65536 && receive(bytes, pauses, 0) > 0) {
        }
        return bytes.size();
    }

private:
    [[noreturn]] static void fail() { throw std::system_error(errno, std::generic_category()); }

    Descriptor descriptor_;
    bool serial_ = false;
};

}  // namespace plumb
