// SPDX-License-Identifier: GPL-2.0-or-later
// Links of modbus_sensor against a device that misbehaves in every way, over TCP and over a serial line.
//
// The device's value is the time at which it made its reply, so that a value that is older than it claims to
// be is found at once. PLUMB_FAULTS is the number of faults; `scripts/campaign sensors` plays many.
#include "components/io/modbus_sensor/modbus_link.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/modbus_bytes.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <pty.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

namespace plumb {
namespace {

using modbus_bytes::Bytes;

enum class Fault {
    none,
    silent,
    late,      // after the link has given up, but before it asks again
    too_late,  // after it has asked again, over a serial line
    slow,      // byte after byte, too slowly
    garbage,
    truncated,
    flood,
    other_device,
    other_function,
    other_size,
    damaged,   // a bit of it
    previous,  // over TCP the reply to another request; on a serial line noise before the reply
    twice,
    exception,
    closed,
    half_closed,  // closed after a part of the reply
    gone,         // closed, and for a while no connection is accepted
    kinds
};

void sleep(double seconds) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

void write_all(int descriptor, const Bytes& bytes) {
    for (std::size_t done = 0; done < bytes.size();) {
        ssize_t count = ::send(descriptor, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
        if (count < 0 && errno == ENOTSOCK)
            count = write(descriptor, bytes.data() + done, bytes.size() - done);
        if (count > 0) {
            done += static_cast<std::size_t>(count);
        } else {
            pollfd room{descriptor, POLLOUT, 0};
            if (count == 0 || errno != EAGAIN || poll(&room, 1, 100) <= 0) return;
        }
    }
}

// Answers requests for four registers by its time as f64, or by the fault that `draw` gives.
class FaultyDevice {
public:
    FaultyDevice(double timeout, double retry, std::function<Fault()> draw)
        : timeout_(timeout), retry_(retry), draw_(std::move(draw)) {}
    virtual ~FaultyDevice() = default;

    void start() {
        thread_ = std::thread([this] {
            while (!stop_) serve();
        });
    }
    void end() {
        stop_ = true;
        if (thread_.joinable()) thread_.join();
    }

    std::atomic<bool> stop_{false};
    std::atomic<int> requests{0};
    std::atomic<int> device{0};  // that the last one is for

protected:
    virtual void serve() = 0;

    // False if the connection ends.
    bool answer(int descriptor, const Bytes& request, bool serial) {
        ++requests;
        const double asked = seconds_now();
        const std::size_t begin = serial ? 0 : 6;
        device = request[begin];
        const Fault fault = healthy_ > 0 ? Fault::none : draw_();
        if (healthy_ > 0) --healthy_;
        const auto reply_at_once = [&] {
            Bytes body{request[begin], 3, 8};
            std::uint16_t words[4];
            encode(seconds_now(), {ModbusEncoding::Type::f64, false, false, 0, 0}, words);
            for (const std::uint16_t word : words) modbus_bytes::add_word(body, word);
            return body;
        };
        const auto framed = [&](Bytes body, const Bytes& of) {
            if (serial) return modbus_bytes::with_checksum(body);
            Bytes bytes{of[0], of[1], 0, 0, 0, static_cast<std::uint8_t>(body.size())};
            bytes.insert(bytes.end(), body.begin(), body.end());
            return bytes;
        };
        Bytes body = reply_at_once();
        Bytes reply = framed(body, request);
        const Bytes before = std::exchange(previous_, reply);
        // A reply that the computer delays beyond the time in which the link waits for it must not be sent.
        const auto send = [&](const Bytes& bytes) {
            if (!serial || seconds_now() - asked < timeout_ + 0.5 * retry_) write_all(descriptor, bytes);
        };
        const std::size_t half = 1 + random_() % (reply.size() - 1);
        switch (fault) {
            case Fault::none: send(reply); return true;
            case Fault::silent: return true;
            case Fault::late:
                sleep(timeout_ + 0.4 * retry_ * static_cast<double>(random_() % 1000) / 1000);
                send(reply);
                return true;
            case Fault::too_late:
                sleep(timeout_ + retry_ * (1 + static_cast<double>(random_() % 3000) / 1000));
                write_all(descriptor, reply);
                healthy_ =
                    4;  // after one delay; a second one while the link makes sure is a limit of the page
                return true;
            case Fault::slow:
                for (const std::uint8_t byte : reply) {
                    if (seconds_now() - asked > timeout_ + 0.4 * retry_) return true;
                    send({byte});
                    sleep(timeout_ / 8);
                }
                return true;
            case Fault::garbage:
                for (std::uint8_t& byte : reply) byte = static_cast<std::uint8_t>(random_());
                reply.resize(half);
                send(reply);
                return true;
            case Fault::truncated:
                send({reply.begin(), reply.begin() + static_cast<long>(half)});
                return true;
            case Fault::flood: {
                Bytes flood(4000);
                for (std::uint8_t& byte : flood) byte = static_cast<std::uint8_t>(random_());
                send(flood);
                return true;
            }
            case Fault::other_device: ++body[0]; break;
            case Fault::other_function: body[1] = 4; break;
            case Fault::other_size:
                body[2] = 6;
                body.resize(9);
                break;
            case Fault::damaged: {
                // Over TCP nothing protects the registers.
                const std::size_t at = random_() % (serial ? reply.size() : 9);
                reply[at] = static_cast<std::uint8_t>(reply[at] ^ 1 << random_() % 8);
                send(reply);
                return true;
            }
            case Fault::previous:
                if (serial) send({static_cast<std::uint8_t>(random_())});
                if (!serial && !ModbusConnection::numbers_requests) ++reply[1];  // all else is the same
                send(serial || before.empty() || !ModbusConnection::numbers_requests ? reply : before);
                return true;
            case Fault::twice:
                reply.insert(reply.end(), reply.begin(), reply.end());
                send(reply);
                return true;
            case Fault::exception:
                body = {request[begin], 0x83, static_cast<std::uint8_t>(random_() % 256)};
                break;
            case Fault::half_closed:
                send({reply.begin(), reply.begin() + static_cast<long>(half)});
                return false;
            case Fault::gone: gone_ = true; return false;
            default: return false;
        }
        send(framed(body, request));
        return true;
    }

    // The next request of the connection; empty if it is closed.
    Bytes request(int descriptor, std::size_t size) {
        Bytes bytes;
        while (bytes.size() < size && !stop_) {
            pollfd waiting{descriptor, POLLIN, 0};
            if (poll(&waiting, 1, 20) <= 0) continue;
            std::uint8_t buffer[64];
            const ssize_t count = read(descriptor, buffer, size - bytes.size());
            if (count <= 0) return {};
            bytes.insert(bytes.end(), buffer, buffer + count);
        }
        return bytes.size() == size ? bytes : Bytes();
    }

    const double timeout_, retry_;
    const std::function<Fault()> draw_;
    std::mt19937 random_{1};
    Bytes previous_;
    bool gone_ = false;
    int healthy_ = 0;  // answers that are without fault
    std::thread thread_;
};

class FaultyServer final : public FaultyDevice {
public:
    template <class... Rest>
    explicit FaultyServer(Rest... rest) : FaultyDevice(rest...) {
        listen_on(0);
    }
    ~FaultyServer() override { end(); }

    int port() const { return port_; }

private:
    void listen_on(int port) {
        listener_ = Descriptor(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
        const int yes = 1;
        setsockopt(listener_.number(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        address.sin_port = htons(static_cast<std::uint16_t>(port));
        if (bind(listener_.number(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
            listen(listener_.number(), 8) != 0)
            std::abort();
        socklen_t size = sizeof address;
        getsockname(listener_.number(), reinterpret_cast<sockaddr*>(&address), &size);
        port_ = ntohs(address.sin_port);
    }

    void serve() override {
        if (std::exchange(gone_, false)) {
            const int port = port_;
            listener_.close();
            sleep(2 * timeout_);
            listen_on(port);
        }
        pollfd waiting{listener_.number(), POLLIN, 0};
        if (poll(&waiting, 1, 20) <= 0) return;
        const Descriptor client(accept4(listener_.number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
        previous_.clear();
        for (;;) {
            const Bytes bytes = request(client.number(), 12);
            if (bytes.empty() || !answer(client.number(), bytes, false)) return;
        }
    }

    Descriptor listener_;
    int port_ = 0;
};

// A pseudo terminal; closed, it is an adapter that was unplugged.
class FaultyLine final : public FaultyDevice {
public:
    template <class... Rest>
    explicit FaultyLine(const std::filesystem::path& path, Rest... rest)
        : FaultyDevice(rest...), path_(path) {
        plug_in();
    }
    ~FaultyLine() override { end(); }

private:
    void plug_in() {
        int master = -1, slave = -1;
        if (openpty(&master, &slave, nullptr, nullptr, nullptr) != 0) std::abort();
        termios raw{};
        tcgetattr(slave, &raw);
        cfmakeraw(&raw);
        tcsetattr(slave, TCSANOW, &raw);
        master_ = Descriptor(master);
        fcntl(master, F_SETFL, O_NONBLOCK);
        std::filesystem::create_symlink("/proc/self/fd/" + std::to_string(slave), path_.string() + ".new");
        slave_ = Descriptor(slave);  // a line without it would end with its last reader
        std::filesystem::rename(path_.string() + ".new", path_);
    }

    void serve() override {
        const Bytes bytes = request(master_.number(), 8);
        if (bytes.empty() || answer(master_.number(), bytes, true)) return;
        std::filesystem::remove(path_);
        master_.close();
        slave_.close();
        sleep(gone_ ? 2 * timeout_ : 0.001);
        gone_ = false;
        plug_in();
    }

    const std::filesystem::path path_;
    Descriptor master_, slave_;
};

constexpr double timeout = 0.01, retry = 0.01, serial_retry = 0.02;  // s

ModbusLinkSettings settings() {
    ModbusLinkSettings link;
    link.name = "link";
    link.timeout = timeout;
    link.retry = retry;
    link.retry_max = 0.04;
    ModbusChannel channel;
    channel.name = "time";
    channel.encoding.type = ModbusEncoding::Type::f64;
    channel.every = 0.001;
    channel.limits.max_age = 0.05;
    link.channels = {channel};
    return link;
}

ModbusLinkSettings to(const FaultyServer& server) {
    ModbusLinkSettings link = settings();
    link.host = "127.0.0.1";
    link.port = std::to_string(server.port());
    return link;
}

ModbusLinkSettings to(const std::filesystem::path& path) {
    ModbusLinkSettings link = settings();
    link.path = path;
    link.serial = {115200, B115200, 'N', 1};
    link.retry = serial_retry;
    return link;
}

Say collected(std::vector<std::string>& said) {
    return [&](const std::string& text) { said.push_back(text); };
}

Reading reading_of(ModbusLink& link) {
    const std::lock_guard lock(link.state().mutex);
    return link.state().judges[0].at(seconds_now());
}

bool becomes(const std::function<bool()>& condition) {
    for (const double until = seconds_now() + 20; seconds_now() < until; sleep(0.001))
        if (condition()) return true;
    return false;
}

int from_environment(const char* name, int initial) {
    const char* const given = std::getenv(name);
    return given ? std::atoi(given) : initial;
}

// A fault after three good replies on average, until `left` is used up.
class Draw {
public:
    Draw(std::atomic<int>& left, unsigned seed) : left_(left), random_(seed) {}
    Fault operator()() {
        if (left_ <= 0 || random_() % 4 != 0) return Fault::none;
        --left_;
        return static_cast<Fault>(1 + random_() % (static_cast<unsigned>(Fault::kinds) - 1));
    }

private:
    std::atomic<int>& left_;
    std::mt19937 random_;
};

TEST(ModbusLinkFaults, NoStaleValueIsValidAndEveryLinkRecovers) {
    const int faults = from_environment("PLUMB_FAULTS", 600);
    const auto seed = static_cast<unsigned>(1000 * from_environment("PLUMB_SEED", 1));
    std::atomic<int> left{faults};
    const Folder folder;
    std::deque<FaultyServer> servers;
    std::deque<FaultyLine> lines;
    std::deque<ModbusLink> links;
    const Say nothing = [](const std::string&) {};
    for (unsigned i = 0; i < 6; ++i) {
        servers.emplace_back(timeout, retry, Draw(left, seed + i));
        links.emplace_back(to(servers.back()), nothing);
    }
    for (unsigned i = 0; i < 6; ++i) {
        const std::filesystem::path path = folder / std::to_string(i);
        lines.emplace_back(path, timeout, serial_retry, Draw(left, seed + 100 + i));
        links.emplace_back(to(path), nothing);
    }
    for (auto& server : servers) server.start();
    for (auto& line : lines) line.start();
    for (auto& link : links) link.start();
    long looks = 0, valid = 0, stale = 0;
    double worst = 0;
    const auto look = [&] {
        for (ModbusLink& link : links) {
            const std::lock_guard lock(link.state().mutex);
            const double now = seconds_now();
            const Reading reading = link.state().judges[0].at(now);
            ++looks;
            if (!reading.valid) continue;
            ++valid;
            // The device made the value after it was asked for, and before now. On a busy computer it may
            // answer an abandoned request over a serial line just before the next one is sent.
            const double tolerance = link.state().settings.is_serial() ? 0.005 : 0;
            const double its_age = now - reading.value;
            if (its_age > reading.age + tolerance || its_age < 0 || reading.age > 0.05) ++stale;
            worst = std::max(worst, its_age);
        }
    };
    double quiet_until = 0;
    int last = faults;
    for (double until = seconds_now() + 30; left > 0 && seconds_now() < until; sleep(0.0002)) {
        look();
        if (left != last) until = seconds_now() + 30;  // it goes on
        last = left;
    }
    EXPECT_LE(left, 0) << "no link asks any more";
    for (ModbusLink& link : links)
        EXPECT_TRUE(becomes([&] {
            look();
            return reading_of(link).valid;
        })) << "does not recover: "
            << link.state().settings.place();
    quiet_until = seconds_now() + 0.05;
    while (seconds_now() < quiet_until) look();
    EXPECT_EQ(stale, 0);
    EXPECT_GT(valid, 0);
    const double began = seconds_now();
    for (ModbusLink& link : links) link.ask_to_stop();
    for (ModbusLink& link : links) link.stop(10);
    EXPECT_LT(seconds_now() - began, 5);
    std::cout << faults - left << " faults, " << looks << " looks, " << 100 * valid / looks
              << " % of them valid, " << stale << " stale, oldest valid value " << 1000 * worst << " ms\n";
}

// One device, and the fault that the test chooses.
class ModbusLinkTest : public testing::Test {
protected:
    ModbusLinkTest() { server.start(); }

    std::atomic<Fault> fault{Fault::none};
    FaultyServer server{timeout, retry, [this] { return fault.load(); }};
    std::vector<std::string> said;
};

// Settings of a serial line for tests of when it asks.
ModbusLinkSettings patient(const std::filesystem::path& line) {
    ModbusLinkSettings its = to(line);
    its.timeout = 0.1;
    its.retry = its.retry_max = 0.12;
    its.channels[0].limits.max_age = 10;
    return its;
}

TEST(ModbusLinkFaults, ADeviceThatIsDeafAfterItsReplyIsGivenAPause) {
    for (const double deaf : {0.01, 0.05}) {
        const Folder folder;
        double replied = 0;
        FaultyLine line(folder / "line", 0.1, 0.12, [&] {
            const double now = seconds_now();
            return now - replied < deaf ? Fault::silent : (replied = now, Fault::none);
        });
        line.start();
        ModbusLinkSettings its = patient(folder / "line");
        its.channels.push_back(its.channels[0]);
        its.channels[1].first = 100;
        std::vector<std::string> said;
        ModbusLink link(its, collected(said));
        link.start();
        const auto all_valid = [&] {
            const std::lock_guard lock(link.state().mutex);
            return link.state().judges[0].at(seconds_now()).valid &&
                   link.state().judges[1].at(seconds_now()).valid;
        };
        EXPECT_TRUE(becomes(all_valid)) << deaf;
        link.stop(5);
        ASSERT_FALSE(said.empty());
        EXPECT_THAT(said.back(), testing::HasSubstr("device 1 has a pause of"));
    }
}

TEST(ModbusLinkFaults, ALineHasOneProgram) {
    const Folder folder;
    FaultyLine line(folder / "line", 0.1, 0.12, [] { return Fault::none; });
    line.start();
    std::vector<std::string> said;
    ModbusLink link(patient(folder / "line"), collected(said));
    link.start();
    ASSERT_TRUE(becomes([&] { return reading_of(link).valid; }));
    std::vector<std::string> said_by_other;
    ModbusLink other(patient(folder / "line"), collected(said_by_other));
    other.start();
    EXPECT_TRUE(becomes([&] { return !said_by_other.empty(); }));
    EXPECT_THAT(said_by_other.front(), testing::HasSubstr("line, 115200 8N1: Device or resource busy"));
    link.stop(5);
    EXPECT_TRUE(becomes([&] { return reading_of(other).valid; }));
    other.stop(5);
}

TEST(ModbusLinkFaults, SilentDevicesTakeNoTurnOfOneThatAnswers) {
    const Folder folder;
    std::vector<int> asked;
    FaultyDevice* device = nullptr;
    FaultyLine line(folder / "line", 0.1, 0.12, [&] {
        asked.push_back(device->device);
        return asked.back() == 1 ? Fault::none : Fault::silent;
    });
    device = &line;
    line.start();
    ModbusLinkSettings its = patient(folder / "line");
    its.timeout = 0.03;
    for (int number = 2; number < 40; ++number) {
        its.channels.push_back(its.channels[0]);
        its.channels.back().device = number;
    }
    std::vector<std::string> said;
    ModbusLink link(its, collected(said));
    link.start();
    EXPECT_TRUE(becomes([&] { return line.requests > 300; }));
    link.stop(5);
    line.end();
    int in_a_row = 0, silent = 0;
    for (std::size_t i = 1; i < asked.size(); ++i) {
        silent += asked[i] != 1;
        in_a_row += asked[i] != 1 && asked[i - 1] != 1;
    }
    EXPECT_GT(silent, 5);
    EXPECT_LT(in_a_row, 0.1 * silent) << "of " << silent << " requests to silent devices";
}

TEST(ModbusLinkFaults, EachHasItsCode) {
    using Code = SensorFault;
    const std::vector<std::tuple<Fault, Code, Code>> cases{
        // over TCP, on a serial line
        {Fault::silent, Code::silent, Code::silent},
        {Fault::too_late, Code::silent, Code::silent},
        {Fault::slow, Code::damaged, Code::damaged},
        {Fault::garbage, Code::damaged, Code::damaged},
        {Fault::truncated, Code::damaged, Code::damaged},
        {Fault::flood, Code::damaged, Code::damaged},
        {Fault::other_device, Code::damaged, Code::damaged},
        {Fault::other_function, Code::damaged, Code::damaged},
        {Fault::other_size, Code::damaged, Code::damaged},
        {Fault::damaged, Code::damaged, Code::damaged},
        {Fault::previous, Code::damaged, Code::none},
        {Fault::twice, Code::damaged, Code::damaged},
        {Fault::exception, Code::refused, Code::refused},
        {Fault::closed, Code::disconnected, Code::disconnected},
        {Fault::half_closed, Code::disconnected, Code::disconnected},
        {Fault::gone, Code::disconnected, Code::disconnected}};
    const double its_timeout = 0.05, its_retry = 0.06;
    const Folder folder;
    std::vector<std::string> said;
    std::atomic<Fault> fault{Fault::none};
    const auto draw = [&] { return fault.load(); };
    FaultyServer server(its_timeout, its_retry, draw);
    FaultyLine line(folder / "line", its_timeout, its_retry, draw);
    for (FaultyDevice* device : {static_cast<FaultyDevice*>(&server), static_cast<FaultyDevice*>(&line)}) {
        device->start();
        const bool serial = device == &line;
        ModbusLinkSettings its = serial ? to(folder / "line") : to(server);
        its.timeout = its_timeout;
        its.retry = its.retry_max = its_retry;
        its.channels[0].limits.max_age = 10;
        for (const auto& [kind, tcp_code, serial_code] : cases) {
            const SensorFault code = serial ? serial_code : tcp_code;
            ModbusLink link(its, collected(said));
            link.start();
            ASSERT_TRUE(becomes([&] { return reading_of(link).valid; }));
            fault = kind;
            EXPECT_TRUE(becomes([&] { return reading_of(link).fault == code; }))
                << (serial ? "line, " : "TCP, ") << static_cast<int>(kind) << " gives "
                << static_cast<int>(reading_of(link).fault);
            fault = Fault::none;
            EXPECT_TRUE(becomes([&] { return reading_of(link).fault == SensorFault::none; }))
                << (serial ? "line, " : "TCP, ") << static_cast<int>(kind);
            link.stop(5);
        }
    }
}

TEST_F(ModbusLinkTest, ADeviceThatDoesNotAnswerIsAskedMoreAndMoreRarely) {
    fault = Fault::silent;
    ModbusLink link(to(server), collected(said));
    link.start();
    ASSERT_TRUE(becomes([&] { return server.requests > 4; }));
    const int before = server.requests;
    sleep(0.5);
    // One request takes a time-out of 10 ms and a pause of 40 ms.
    EXPECT_LE(server.requests - before, 12);
    link.stop(5);
    EXPECT_THAT(said, testing::ElementsAre(testing::HasSubstr("no reply"))) << "said once";
}

TEST_F(ModbusLinkTest, OneDeviceThatDoesNotAnswerDoesNotHoldUpAnother) {
    ModbusLinkSettings its = to(server);
    its.channels.push_back(its.channels[0]);
    its.channels[1].device = 2;
    its.timeout = 0.1;
    its.retry = its.retry_max = 10;
    std::atomic<int> asked{0};
    FaultyServer other(0.1, retry, [&] { return ++asked == 1 ? Fault::silent : Fault::none; });
    other.start();
    its.port = std::to_string(other.port());
    ModbusLink link(its, collected(said));
    link.start();
    EXPECT_TRUE(becomes([&] { return other.requests > 50; }));
    {
        const std::lock_guard lock(link.state().mutex);
        EXPECT_TRUE(link.state().connected);
        EXPECT_EQ(link.state().judges[0].at(seconds_now()).fault, SensorFault::silent);
        EXPECT_EQ(link.state().judges[1].at(seconds_now()).fault, SensorFault::none);
    }
    link.stop(5);
}

TEST_F(ModbusLinkTest, ItsEndNeverWaitsForADevice) {
    ModbusLinkSettings its = to(server);
    its.timeout = 10;
    its.retry_max = 3600;
    for (const Fault kind : {Fault::silent, Fault::truncated, Fault::none}) {
        fault = kind;
        ModbusLink link(its, collected(said));
        link.start();
        const int before = server.requests;
        ASSERT_TRUE(becomes([&] { return server.requests > before; }));
        const double began = seconds_now();
        link.stop(5);
        EXPECT_LT(seconds_now() - began, 1) << static_cast<int>(kind);
    }
}

TEST_F(ModbusLinkTest, ItsEndNeverWaitsForANameServer) {
    ModbusLinkSettings its = to(server);
    its.host = "no-such-host.invalid";
    ModbusLink link(its, collected(said));
    link.start();
    EXPECT_TRUE(becomes([&] {
        const std::lock_guard lock(link.state().mutex);
        return link.state().fault == ModbusLinkFault::name;
    }));
    const double began = seconds_now();
    link.stop(5);
    EXPECT_LT(seconds_now() - began, 1);
}

// A device on a pseudo terminal, whose replies the test chooses, and a link that asks it.
class ModbusSerialLine : public testing::Test {
protected:
    ModbusSerialLine() {
        int ends[2];
        if (openpty(&ends[0], &ends[1], nullptr, nullptr, nullptr) != 0) std::abort();
        device = Descriptor(ends[0]);
        slave = Descriptor(ends[1]);
        termios raw{};
        cfmakeraw(&raw);
        tcsetattr(slave.number(), TCSANOW, &raw);
        std::filesystem::create_symlink("/proc/self/fd/" + std::to_string(slave.number()), folder / "line");
        ModbusLinkSettings its = to(folder / "line");
        its.timeout = its.retry = its.retry_max = 0.5;
        its.channels[0].encoding.type = ModbusEncoding::Type::u16;
        its.channels[0].every = 1;
        its.channels[0].limits.max_age = 10;
        link.emplace(its, collected(said));
        link->start();
    }
    ~ModbusSerialLine() override { link->stop(5); }

    // Returns when the link has asked; false if it does not in time.
    bool asked(double seconds = 20) {
        Bytes bytes;
        for (const double until = seconds_now() + seconds; bytes.size() < 8 && seconds_now() < until;) {
            pollfd waiting{device.number(), POLLIN, 0};
            std::uint8_t buffer[8];
            if (poll(&waiting, 1, 5) <= 0) continue;
            const ssize_t count = read(device.number(), buffer, 8 - bytes.size());
            bytes.insert(bytes.end(), buffer, buffer + std::max<ssize_t>(count, 0));
        }
        return bytes.size() == 8;
    }
    void answer(std::uint8_t value) {
        write_all(device.number(), modbus_bytes::with_checksum({1, 3, 2, 0, value}));
    }
    // Answers until the link takes the value, which it should; returns how many answers that took.
    int answers_until(std::uint8_t value) {
        int answers = 0;
        EXPECT_TRUE(becomes([&] {
            if (asked(0.02)) answer(value), ++answers;
            return reading_of(*link).valid && reading_of(*link).value == value;
        }));
        return answers;
    }
    bool ever_valid() {
        for (const double until = seconds_now() + 0.05; seconds_now() < until; sleep(0.001))
            if (reading_of(*link).valid) return true;
        return false;
    }

    const Folder folder;
    Descriptor device, slave;
    std::vector<std::string> said;
    std::optional<ModbusLink> link;
};

TEST_F(ModbusSerialLine, AReplyLaterThanTheRetryIsNoValue) {
    ASSERT_TRUE(asked());  // 1
    ASSERT_TRUE(asked());  // 2
    answer(1);
    EXPECT_FALSE(ever_valid()) << "it is the reply to the first request";
    ASSERT_TRUE(asked());  // 3
    answer(2);
    EXPECT_FALSE(ever_valid()) << "another reply may follow";
    answer(3);
    EXPECT_FALSE(ever_valid()) << "it has followed";
    EXPECT_EQ(reading_of(*link).fault, SensorFault::damaged);
    ASSERT_TRUE(asked());  // 4
    answer(4);
    EXPECT_FALSE(ever_valid()) << "it is dropped again";
    answers_until(5);
}

TEST_F(ModbusSerialLine, AReplyThatIsLostCostsTwoRequests) {
    answers_until(1);
    ASSERT_TRUE(asked());
    EXPECT_TRUE(becomes([&] { return reading_of(*link).fault == SensorFault::silent; }));
    const int answers = answers_until(3);
    const int failed = reading_of(*link).errors;
    EXPECT_GE(answers, 2);
    EXPECT_LE(answers, 2 * failed + 1) << "it may ask again before this thread looks";
    EXPECT_EQ(reading_of(*link).fault, SensorFault::none);
}

TEST_F(ModbusSerialLine, AReplyThatNobodyAskedForMakesTheValueInvalid) {
    answers_until(1);
    while (asked(0.3)) answer(1);
    answer(2);
    EXPECT_TRUE(becomes([&] { return !reading_of(*link).valid; }));
    EXPECT_EQ(reading_of(*link).fault, SensorFault::damaged);
    EXPECT_GE(answers_until(3), 2);
}

// libmodbus's own server, over TCP or on a pseudo terminal: ten registers and bits of each table, whose value
// is their number and 100, 200 more.
class LibmodbusServer {
public:
    explicit LibmodbusServer(const std::filesystem::path& line = {})
        : modbus_(line.empty() ? modbus_new_tcp("127.0.0.1", 0) : modbus_new_rtu("line", 115200, 'N', 8, 1)),
          mapping_(modbus_mapping_new(10, 10, 10, 10)) {
        for (int i = 0; i < 10; ++i) {
            mapping_->tab_registers[i] = static_cast<std::uint16_t>(100 + i);
            mapping_->tab_input_registers[i] = static_cast<std::uint16_t>(200 + i);
            mapping_->tab_bits[i] = i % 2 == 0;
            mapping_->tab_input_bits[i] = i % 2 == 1;
        }
        modbus_set_slave(modbus_, 1);
        modbus_set_indication_timeout(modbus_, 0, 20000);
        if (line.empty()) {
            listener_ = Descriptor(modbus_tcp_listen(modbus_, 1));
            sockaddr_in address{};
            socklen_t size = sizeof address;
            getsockname(listener_.number(), reinterpret_cast<sockaddr*>(&address), &size);
            port = ntohs(address.sin_port);
        } else {
            int ends[2];
            if (openpty(&ends[0], &ends[1], nullptr, nullptr, nullptr) != 0) std::abort();
            master_ = Descriptor(ends[0]);
            slave_ = Descriptor(ends[1]);
            termios raw{};
            cfmakeraw(&raw);
            tcsetattr(slave_.number(), TCSANOW, &raw);
            std::filesystem::create_symlink("/proc/self/fd/" + std::to_string(slave_.number()), line);
            modbus_set_socket(modbus_, master_.number());
        }
        thread_ = std::thread([this] { serve(); });
    }
    ~LibmodbusServer() {
        stop_ = true;
        thread_.join();
        modbus_mapping_free(mapping_);
        modbus_free(modbus_);
    }

    int port = 0;

private:
    void serve() {
        while (!stop_) {
            if (!master_ && !client_) {
                pollfd waiting{listener_.number(), POLLIN, 0};
                if (poll(&waiting, 1, 20) <= 0) continue;
                client_ = Descriptor(accept(listener_.number(), nullptr, nullptr));
                modbus_set_socket(modbus_, client_.number());
            }
            std::uint8_t request[MODBUS_MAX_ADU_LENGTH];
            const int size = modbus_receive(modbus_, request);
            if (size > 0) modbus_reply(modbus_, request, size, mapping_);
            if (size < 0 && errno != ETIMEDOUT) client_.close();
        }
    }

    modbus_t* const modbus_;
    modbus_mapping_t* const mapping_;
    Descriptor listener_, client_, master_, slave_;
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

TEST(ModbusLinkPeers, TheServerOfLibmodbusIsReadAndWritten) {
    for (const bool serial : {false, true}) {
        const Folder folder;
        const LibmodbusServer server(serial ? folder / "line" : std::filesystem::path());
        ModbusLinkSettings its = serial ? to(folder / "line") : settings();
        its.host = "127.0.0.1";
        its.port = std::to_string(server.port);
        its.timeout = its.retry = 0.2;
        const auto channel = [](const char* name, ModbusTable table, int first, bool output = false) {
            ModbusChannel result;
            result.name = name;
            result.table = table;
            result.first = first;
            result.every = 0.01;
            result.output = output;
            return result;
        };
        its.channels = {
            channel("holding", ModbusTable::holding, 3),  channel("input", ModbusTable::input, 4),
            channel("coil", ModbusTable::coil, 6),        channel("discrete", ModbusTable::discrete, 7),
            channel("written", ModbusTable::holding, 8),  channel("register", ModbusTable::holding, 8, true),
            channel("lamp", ModbusTable::coil, 1, true),  channel("lit", ModbusTable::coil, 1),
            channel("missing", ModbusTable::holding, 500)};
        std::vector<std::string> said;
        ModbusLink link(its, collected(said));
        link.state().commands[5] = {true, 4711};
        link.state().commands[6] = {true, 1};
        link.start();
        const auto is = [&](std::size_t i, double value) {
            return becomes([&] {
                const std::lock_guard lock(link.state().mutex);
                const Reading reading = link.state().judges[i].at(seconds_now());
                return reading.valid && reading.value == value;
            });
        };
        EXPECT_TRUE(is(0, 103)) << serial;
        EXPECT_TRUE(is(1, 204)) << serial;
        EXPECT_TRUE(is(2, 1)) << serial;
        EXPECT_TRUE(is(3, 1)) << serial;
        EXPECT_TRUE(is(4, 4711)) << serial;
        EXPECT_TRUE(is(5, 4711)) << serial;
        EXPECT_TRUE(is(6, 1)) << serial;
        EXPECT_TRUE(is(7, 1)) << serial;
        EXPECT_TRUE(becomes([&] {
            const std::lock_guard lock(link.state().mutex);
            return link.state().judges[8].at(seconds_now()).fault == SensorFault::refused;
        }));
        {
            const std::lock_guard lock(link.state().mutex);
            EXPECT_EQ(link.state().judges[0].at(seconds_now()).errors, 0) << "no request failed meanwhile";
        }
        link.stop(5);
    }
}

}  // namespace
}  // namespace plumb
