#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tests the completion of shells: what osteon prints for it, and the scripts of completion/ in each shell that is
# installed.
# Covers: REQ-CLI-HELP
. "${srcdir:-.}/tests/app/lib.sh"
mkdir bin
ln -s "$osteon" bin/osteon
PATH=$PWD/bin:$PATH
tab=$(printf '\t')

# Each verb and each option of the help text must be printed, in the same order.
check "verbs" "$(osteon --complete | cut -f 1)" "$(osteon --help | sed -n '/^verbs$/,/^$/s/^  \([a-z]*\) .*/\1/p')"
osteon --complete | cut -f 1 >verbs
while read -r verb; do
    check "options of $verb" "$(osteon "$verb" --complete | cut -f 1)" "$(osteon "$verb" --help | sed -n 's/^  \(--[a-z-]*\).*/\1/p')"
    check "lines of $verb without three fields" "$(osteon "$verb" --complete | awk -F '\t' 'NF != 3 || $2 == "" || $3 == ""')" ""
done <verbs
check "values of the option --style of render" "$(osteon render --complete | grep "^--style$tab" | cut -f 2)" "smooth|faces"
check "kind of the option --json of render" "$(osteon render --complete | grep "^--json$tab" | cut -f 2)" flag

touch bone.nrrd path.csv
# The words that each shell proposes are compared with those that must and must not be among them.
# proposes SHELL LINE WORD...: checks that the shell's words for the line are exactly these
proposes() {
    shown="$1: $2"
    words=$("complete_$1" "$2" | LC_ALL=C sort -u | tr '\n' ' ')
    shift 2
    check "$shown" "${words% }" "$(printf '%s\n' "$@" | LC_ALL=C sort | tr '\n' ' ' | sed 's/ $//')"
}

complete_bash() {
    bash --norc -c '
        . "$1/completion/bash/osteon"
        COMP_LINE=$2
        # bash divides words at blanks and at "="
        read -r -a COMP_WORDS <<<"${COMP_LINE//=/ = }"
        case $COMP_LINE in *" ") COMP_WORDS+=("") ;; esac
        COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
        _osteon
        printf "%s\n" "${COMPREPLY[@]}"' bash "$source_folder" "$1"
}
complete_fish() {
    HOME=$scratch XDG_CONFIG_HOME=$scratch XDG_DATA_HOME=$scratch XDG_CACHE_HOME=$scratch fish --no-config -c '
        source $argv[1]/completion/fish/osteon.fish
        complete -C $argv[2]' "$source_folder" "$1" | cut -f 1
}
# zsh completes in a pseudo-terminal. Each candidate is recorded by a replacement of compadd.
complete_zsh() {
    TERM=dumb zsh -f -c '
        zmodload zsh/zpty
        zpty shell zsh -f -i
        zpty -w shell "PROMPT= ; PS1= ; unsetopt zle_bracketed_paste; fpath=($1/completion/zsh \$fpath); autoload -Uz compinit; compinit -u -D"
        zpty -w shell "compadd() {
            if [[ \${@[(I)-O]} -gt 0 || \${@[(I)-A]} -gt 0 || \${@[(I)-D]} -gt 0 ]]; then builtin compadd \"\$@\"; return; fi
            local -a found; builtin compadd -O found \"\$@\"; print -rl -- \$found >>words; builtin compadd \"\$@\"
        }"
        zpty -w shell "bindkey \"^I\" complete-word; print ready"
        while zpty -r shell line; do [[ $line == *ready* && $line != *print* ]] && break; done
        zpty -n -w shell "$2"$'"'\\t'"'
        for i in {1..100}; do [[ -s words ]] && break; sleep 0.05; done
        sleep 0.1
        zpty -d shell' zsh "$source_folder" "$1"
    cat words 2>/dev/null
    rm -f words
}

tried=0
for shell in bash zsh fish; do
    if ! command -v $shell >/dev/null; then
        echo "not tested, because it is not installed: $shell"
        continue
    fi
    tried=$((tried + 1))
    proposes $shell "osteon rep" replay reproduce
    proposes $shell "osteon render --sty" --style
    proposes $shell "osteon render --style " smooth faces
    case $shell in
    fish) proposes $shell "osteon render --style=sm" --style=smooth ;;
    *) proposes $shell "osteon render --style=sm" smooth ;;
    esac
    proposes $shell "osteon ream --bone bo" bone.nrrd
    proposes $shell "osteon info pa" path.csv
done
[ $tried -gt 0 ] || { echo "skipped: no bash, zsh or fish"; exit 77; }
finish
