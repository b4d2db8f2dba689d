#include "watch_screen.h"

#include <clocale>
#include <cstring>

#define NCURSES_NOMACROS  // They have names like move and erase.
#include <curses.h>
#include <langinfo.h>
#include <unistd.h>

#include "vantage/math/error.h"

namespace vantage {
namespace {

SCREEN* screen = nullptr;  // ncurses has one terminal a process.

chtype Attributes(TextStyle style) {
  switch (style) {
    case TextStyle::kPlain:
      return A_NORMAL;
    case TextStyle::kDim:
      return A_DIM;
    case TextStyle::kTitle:
      return COLOR_PAIR(1) | A_BOLD;
    case TextStyle::kValue:
      return A_BOLD;
    case TextStyle::kGood:
      return COLOR_PAIR(2) | A_BOLD;
    case TextStyle::kWarning:
      return COLOR_PAIR(3) | A_BOLD;
    case TextStyle::kBad:
      return COLOR_PAIR(4) | A_BOLD;
    case TextStyle::kCurve:
      return COLOR_PAIR(5);
  }
  return A_NORMAL;
}

}  // namespace

WatchScreen::WatchScreen() {
  std::setlocale(LC_ALL, "");
  // The curves are made of letters that only UTF-8 has.
  if (std::strcmp(nl_langinfo(CODESET), "UTF-8") != 0) std::setlocale(LC_CTYPE, "C.UTF-8");
  // Unlike initscr(), newterm() reports a failure instead of ending the program.
  screen = newterm(nullptr, stdout, stdin);
  if (screen == nullptr) throw Error("this terminal cannot show a full-screen view (TERM?)");
  cbreak();
  noecho();
  curs_set(0);
  keypad(stdscr, TRUE);
  if (has_colors()) {
    start_color();
    use_default_colors();
    init_pair(1, COLOR_CYAN, -1);
    init_pair(2, COLOR_GREEN, -1);
    init_pair(3, COLOR_YELLOW, -1);
    init_pair(4, COLOR_RED, -1);
    init_pair(5, COLOR_BLUE, -1);
  }
}

WatchScreen::~WatchScreen() {
  endwin();
  delscreen(screen);
  screen = nullptr;
}

int WatchScreen::columns() const {
  return COLS;
}

int WatchScreen::rows() const {
  return LINES;
}

void WatchScreen::Draw(const std::vector<TextLine>& lines) {
  erase();
  int row = 0;
  for (const TextLine& line : lines) {
    move(row++, 0);
    for (const TextSpan& span : line) {
      attrset(static_cast<int>(Attributes(span.style)));
      addstr(span.text.c_str());
    }
  }
  refresh();
}

int WatchScreen::Key(Duration timeout) {
  ::timeout(static_cast<int>(timeout / std::chrono::milliseconds(1)));
  const int key = getch();
  return key == ERR || key == KEY_RESIZE ? 0 : key;
}

}  // namespace vantage
