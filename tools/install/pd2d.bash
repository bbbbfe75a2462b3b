# bash completion of pd1d, pd2d and pd3d: options, scenes, templates, sections and keys.
_pdcorr() {
    local program=$1 word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} words=""
    local options="--estimate-error --accuracy --out --checkpoint --resume --sweep --fit --to --threads --memory-limit
        --follow --live --progress --quiet --check --speciate --titrate --new --keys --version --help"
    COMPREPLY=()
    case $before in
    --new) words=$("$program" --new 2> /dev/null) ;;
    --keys) words=$("$program" --keys 2> /dev/null | sed 's/^\[\([a-z]*\).*/\1/') ;;
    --out) mapfile -t COMPREPLY < <(compgen -d -- "$word"); return ;;
    --to) mapfile -t COMPREPLY < <(compgen -f -- "$word"); return ;;
    --accuracy | --checkpoint | --sweep | --fit | --threads | --memory-limit | --progress | --titrate) return ;;
    *)
        case $word in
        -*) words=$options ;;
        *)
            mapfile -t COMPREPLY < <(compgen -f -X '!*.scene' -- "$word"; compgen -f -X '!*.cfg' -- "$word"
                compgen -f -X '!*.electrolyte' -- "$word"
                compgen -d -S / -- "$word")
            return ;;
        esac ;;
    esac
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
}
complete -F _pdcorr pd1d pd2d pd3d
