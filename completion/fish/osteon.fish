# SPDX-License-Identifier: Apache-2.0
# fish completion of osteon. The words come from `osteon --complete` and `osteon VERB --complete`;
# bash/osteon describes their lines.

function __osteon_candidates
    set -l tokens (commandline -opc)
    set -l word (commandline -ct)
    if test (count $tokens) -eq 1
        $tokens[1] --complete 2>/dev/null
        return
    end
    set -l rows ($tokens[1] $tokens[2] --complete 2>/dev/null)
    set -l name $tokens[-1]
    set -l prefix ''
    # --name=value is one word.
    if string match -q -- '--*=*' $word
        set name (string split -m 1 = -- $word)[1]
        set prefix $name=
    end
    for row in $rows
        set -l fields (string split \t -- $row)
        if test "$fields[1]" = "$name"; and test "$fields[2]" != flag
            switch $fields[2]
                case '*|*'
                    printf '%s\n' $prefix(string split '|' -- $fields[2])
                case file
                    printf '%s\n' $prefix(__fish_complete_path (string replace -- "$prefix" '' $word))
            end
            return
        end
    end
    if string match -q -- '-*' $word
        for row in $rows
            set -l fields (string split \t -- $row)
            printf '%s\t%s\n' $fields[1] $fields[3]
        end
    else
        __fish_complete_path $word
    end
end

complete -c osteon -f -a '(__osteon_candidates)'
