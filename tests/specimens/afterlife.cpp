// SPDX-License-Identifier: GPL-2.0-or-later
// Notes in a file that it is destroyed, and each call of update() after that.
#include "hal/component.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace plumb {

struct Afterlife final : hal::Component {
    static constexpr hal::About about{"afterlife", "notes calls after its end",
                                      "Writes a d when it is destroyed, and a u for each update after that."};

    using Component::Component;
    ~Afterlife() override {
        destroyed_ = true;
        note('d');
        std::this_thread::sleep_for(std::chrono::milliseconds(50));  // for calls that are to be counted
    }

    hal::Out<std::int32_t> calls{this, "calls", "Calls of update."};
    hal::Option<std::string> notes{this, "notes", "", "File for the notes, absolute path."};
    hal::Function run{this, "update", &Afterlife::update, "Anywhere."};

    void prepare() override { file_ = open(notes.get().c_str(), O_WRONLY | O_APPEND | O_CLOEXEC); }

    void update(double) noexcept {
        calls = ++count_;
        if (destroyed_) note('u');
    }

private:
    void note(char what) const noexcept {
        if (write(file_, &what, 1) < 0) return;
    }

    int file_ = -1;  // stays open, for the calls that are to be counted
    std::int32_t count_ = 0;
    std::atomic<bool> destroyed_{false};
};

hal::Model hal::model() {
    return model_of<Afterlife>();
}

}  // namespace plumb
