# SPDX-License-Identifier: Apache-2.0
# Functions that .ci/run and .ci/long share: gates, their logs, and the sum of their results.
#
# A gate is a command with a name and a time limit. Its output is stored in build/ci/NAME.log;
# the end of the log is shown if the gate fails. A gate that runs make check counts the tests in
# the summary of its log; any other gate counts as one.

shopt -s extglob
logs=build/ci
passed=0
failed=0
skipped=0
mkdir -p "$logs"

# add PASSED FAILED SKIPPED: adds the counts to the sum
add() {
	passed=$((passed + $1))
	failed=$((failed + $2))
	skipped=$((skipped + $3))
}

# counts LOG: prints the numbers of passed, failed and skipped tests in all summaries of the log. A
# summary is that of automake or the last line of a gate.
counts() {
	sed 's/\x1b\[[0-9;]*m//g' "$1" | awk '
		/^# (PASS|XFAIL):/ { p += $3 }
		/^# (FAIL|XPASS|ERROR):/ { f += $3 }
		/^# SKIP:/ { s += $3 }
		/^[0-9]+ passed, [0-9]+ failed, [0-9]+ skipped$/ { p += $1; f += $3; s += $5 }
		END { print p + 0, f + 0, s + 0 }'
}

# gate NAME LIMIT COMMAND...: runs a command with a time limit in seconds. If $shown is set, it is
# displayed instead of the command.
shown=
gate() {
	local name=$1 limit=$2 begin=$SECONDS status=0 p f s
	local log=$logs/$name.log
	shift 2
	printf '\n== %s\n$ %s\n' "$name" "${shown:-$*}"
	timeout --kill-after=10 "$limit" "$@" >"$log" 2>&1 </dev/null || status=$?
	read -r p f s < <(counts "$log")
	if [ "$status" -eq 77 ]; then
		tail -n 1 "$log"
		add 0 0 1
		printf '%s: skipped\n' "$name"
		return
	fi
	# A command that fails without a failed test in its log counts as one failure.
	if [ "$status" -ne 0 ] && [ "$f" -eq 0 ]; then f=1; fi
	if [ "$status" -eq 0 ] && [ $((p + f + s)) -eq 0 ]; then p=1; fi
	add "$p" "$f" "$s"
	if [ "$status" -eq 0 ]; then
		printf '%s: %d passed, %d failed, %d skipped (%d s)\n' "$name" "$p" "$f" "$s" $((SECONDS - begin))
	else
		[ "$status" -ne 124 ] || echo "stopped: it ran longer than $limit s" >>"$log"
		printf '%s: FAILED, status %d (%d s); the failures and the end of %s:\n' "$name" "$status" $((SECONDS - begin)) "$log"
		grep -aE '^(FAIL|ERROR|XPASS|FAILED): ?' "$log" | sort -u | head -n 20
		tail -n 30 "$log" | sed 's/^/    /'
		failed_tests "$log" "$logs/$name"
	fi
	grep -aE '^SKIP: ' "$log" | sort -u | sed 's/^/  /'
	return 0
}

# failed_tests LOG FOLDER: prints the failures and the end of the log of each failed test. The tests
# are in FOLDER or, by default, in build/.
failed_tests() {
	local test log folder=$2
	[ -d "$folder" ] || folder=build
	sed -n 's/^\(FAIL\|ERROR\): //p' "$1" | sort -u | while read -r test; do
		for log in "$folder/$test.log" "$folder/${test%.*}.log"; do
			[ -e "$log" ] || continue
			printf '  %s:\n' "$log"
			grep -aE '^\[ +(ERROR|LINE) +\]|runtime error:' "$log" | head -n 10 | sed 's/^/    /' || :
			tail -n 20 "$log" | sed 's/^/    /'
			break
		done
	done
}

# packages NAME...: installs missing packages, as root or through sudo; a gate whose program is
# still missing is skipped.
packages() {
	local name missing=() prefix=()
	command -v dpkg-query >/dev/null || return 0
	for name; do
		[ "$(dpkg-query -W -f '${db:Status-Status}' "$name" 2>/dev/null)" = installed ] || missing+=("$name")
	done
	[ ${#missing[@]} -gt 0 ] || return 0
	[ "$(id -u)" -eq 0 ] || prefix=(sudo -n)
	printf '\n== packages\n$ apt-get install %s\n' "${missing[*]}"
	{ "${prefix[@]}" apt-get update -q &&
		"${prefix[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}"; } \
		>"$logs/packages.log" 2>&1 || { tail -n 5 "$logs/packages.log"; echo "not installed: their gates are skipped"; }
}

# listed FOLDER VARIABLE: prints a variable of the Makefile of a configured folder
listed() {
	printf 'include Makefile\nlist:\n\t@echo $(%s)\n' "$2" | make -s -C "$1" -f - list
}

# listed_but FOLDER VARIABLE EXCEPT: prints the words of a variable, such as TESTS or check_PROGRAMS,
# except those that match the pattern
listed_but() {
	local word
	for word in $(listed "$1" "$2"); do
		# shellcheck disable=SC2254 # a pattern
		case $word in $3) ;; *) printf '%s ' "$word" ;; esac
	done
}

# build_and_check FOLDER EXCEPT CONFIGURE_ARGUMENT...: builds and tests; `gate` calls it in a
# separate shell
build_and_check() {
	local folder=$1 except=$2 source
	shift 2
	source=$(pwd)
	mkdir -p "$folder"
	(cd "$folder" && "$source/configure" -q --enable-werror "$@") &&
		make -C "$folder" -s -j "$(nproc)" &&
		make -C "$folder" -s -j "$(nproc)" check TESTS="$(listed_but "$folder" TESTS "$except")" check_PROGRAMS="$(listed_but "$folder" check_PROGRAMS "$except")"
}
export -f listed listed_but build_and_check

# check NAME LIMIT EXCEPT CONFIGURE_ARGUMENT...: runs a gate that builds and tests a variant. EXCEPT
# is a pattern, @(A|B), of the tests whose result in this variant cannot differ from the result in
# the first gate.
check() {
	local name=$1 limit=$2 except=$3
	shift 3
	shown="cd build/ci/$name && ../../../configure --enable-werror $* && make && make check${except:+ but for $except}"
	gate "$name" "$limit" bash -O extglob -c 'build_and_check "$@"' _ "build/ci/$name" "$except" "$@"
	shown=
}

# finish: prints the last line in a fixed form. The exit status agrees with this line.
finish() {
	printf '\nall gates: %d s\n' "$SECONDS"
	printf '%d passed, %d failed, %d skipped\n' "$passed" "$failed" "$skipped"
	[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
}
