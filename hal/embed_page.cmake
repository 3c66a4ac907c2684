# SPDX-License-Identifier: GPL-2.0-or-later
# cmake -D PAGE=FILE -D HEADER=FILE -P embed_page.cmake: writes the text of a page, without its first line, as a C++ header.
file(READ ${PAGE} text)
if(NOT text MATCHES "^SPDX-License-Identifier: GPL-2.0-or-later\n")
  message(FATAL_ERROR "${PAGE}: the first line is not SPDX-License-Identifier: GPL-2.0-or-later")
endif()
string(LENGTH "SPDX-License-Identifier: GPL-2.0-or-later\n" length)
string(SUBSTRING "${text}" ${length} -1 text)
file(WRITE ${HEADER} "namespace plumb {\nconstexpr char page[] = R\"page(${text})page\";\n}\n")
